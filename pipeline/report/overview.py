"""What an experiment has come to, a row a step: to be read in a terminal."""

from collections.abc import Iterator
from statistics import fmean

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS, measure
from pipeline.evaluation.wording import FORMS, NOTHING, count
from pipeline.report.endings import left_the_road, stopped_short
from pipeline.report.tables import NAIVE, SAFE
from pipeline.rollout.strategies import Strategy

HEADER = (
    "Run",
    "Iteration",
    "Seeds",
    "Laps, naive",
    "Laps, safe",
    "Takeover, safe",
    "Failed, naive",
    "Queries",
)
"""Pairs are without / with traffic. Failed are drives that did not do all laps; queries are those of
the loop so far, the mean over the seeds.
"""


def overview(experiment: Experiment) -> Iterator[list[str]]:
    """A row for each run and iteration, over its seeds, under HEADER."""
    for run in experiment.runs:
        for iteration in experiment.iterations(run):
            seeds = [step.seed for step in experiment.of(run, iteration)]
            asked = fmean(experiment.queries(seed, run, iteration) for seed in seeds)
            yield [
                experiment.title(run),
                str(iteration),
                ", ".join(map(str, seeds)),
                _pair(experiment, run, iteration, "laps", NAIVE),
                _pair(experiment, run, iteration, "laps", SAFE),
                _pair(experiment, run, iteration, "takeover", SAFE),
                _failed(experiment, run, iteration),
                count(round(asked)),
            ]


def _pair(experiment: Experiment, run: str, iteration: int, metric: str, strategy: Strategy) -> str:
    form = FORMS[METRICS[metric].form].value
    drives = experiment.among(run=run, iteration=iteration, strategy=strategy)
    groups = [among(drives, condition=where) for where in CONDITIONS]
    return " / ".join(
        NOTHING if group.empty else form(measure(group, METRICS)[metric]) for group in groups
    )


def _failed(experiment: Experiment, run: str, iteration: int) -> str:
    drives = experiment.among(run=run, iteration=iteration, strategy=NAIVE)
    return f"{(left_the_road(drives) | stopped_short(drives)).sum()} of {len(drives)}"
