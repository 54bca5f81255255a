"""How the drives ended that did not do all laps."""

from collections.abc import Iterator

import pandas as pd

from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import NOTHING, table
from pipeline.rollout.strategies import DRIVING, Strategy


def left_the_road(drives: pd.DataFrame) -> pd.Series:
    """Which of them ended beside the road."""
    return drives.off_road > 0


def stopped_short(drives: pd.DataFrame) -> pd.Series:
    """Which ended on the road before LAPS were done: stood still, or out of time."""
    return (drives.laps < LAPS) & ~left_the_road(drives)


def endings(experiment: Experiment) -> Iterator[str]:
    """In counts, a table for each driving strategy with drives that did not do all laps; a sentence
    for the others.
    """
    for strategy in DRIVING:
        drives = experiment.among(strategy=strategy)
        if _failed(drives):
            header = ["Left the road", "Stopped on the road"]
            titles = [f"{title}, {strategy}" for title in header]
            yield table(["Run", "Iteration", *titles], list(_rows(experiment, strategy)))
        elif not drives.empty:
            yield f"All {strategy} drives did {LAPS:g} laps."


def _rows(experiment: Experiment, strategy: Strategy) -> Iterator[list[str]]:
    """Of each run and iteration that has such drives."""
    for run in experiment.runs:
        for iteration in experiment.iterations(run):
            drives = experiment.among(run=run, iteration=iteration, strategy=strategy)
            if _failed(drives):
                groups = [among(drives, condition=where) for where in CONDITIONS]
                left = [left_the_road(group) for group in groups]
                stopped = [stopped_short(group) for group in groups]
                yield [experiment.title(run), str(iteration), _counts(left), _counts(stopped)]


def _failed(drives: pd.DataFrame) -> bool:
    return bool((left_the_road(drives) | stopped_short(drives)).any())


def _counts(groups: list[pd.Series]) -> str:
    """Without and with traffic."""
    return " / ".join(
        f"{ended.sum()} of {len(ended)}" if len(ended) else NOTHING for ended in groups
    )
