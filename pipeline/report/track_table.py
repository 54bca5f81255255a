"""What each run has come to on each test track."""

import pandas as pd

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS, measure
from pipeline.evaluation.wording import FORMS, NOTHING, table
from pipeline.report.tables import NAIVE, SAFE
from pipeline.rollout.strategies import Strategy

SHOWN = (("laps", NAIVE), ("laps", SAFE), ("damage_per_lap", NAIVE), ("takeover", SAFE))


def by_track(experiment: Experiment) -> str:
    """A row for each run and track, after the run's last iteration, over all its seeds."""
    rows = []
    for run in experiment.runs:
        last = experiment.among(run=run, iteration=experiment.iterations(run)[-1])
        for track, drives in last.groupby("scenario"):
            rows.append(
                [experiment.title(run), str(track), *(_cell(drives, *each) for each in SHOWN)]
            )
    header = [f"{METRICS[metric].title}, {strategy}" for metric, strategy in SHOWN]
    return table(["Run", "Track", *header], rows, words=2)


def _cell(drives: pd.DataFrame, metric: str, strategy: Strategy) -> str:
    """By condition; NOTHING where nobody drove."""
    form = FORMS[METRICS[metric].form].value
    groups = [among(drives, strategy=strategy, condition=where) for where in CONDITIONS]
    return " / ".join(
        NOTHING if each.empty else form(measure(each, METRICS)[metric]) for each in groups
    )
