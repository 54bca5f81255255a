"""How the drives ended that did not do all laps."""

from collections.abc import Callable, Iterator

from pipeline.evaluation.experiment import RUNS, Experiment
from pipeline.evaluation.outcomes import Outcome
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import NOTHING, table
from pipeline.rollout.strategies import DRIVING, Strategy


def left_the_road(drive: Outcome) -> bool:
    """It ended beside the road."""
    return drive.off_road


def stopped_short(drive: Outcome) -> bool:
    """It ended on the road before LAPS were done: stood still, or out of time."""
    return drive.laps < LAPS and not drive.off_road


def endings(experiment: Experiment) -> Iterator[str]:
    """In counts, a table for each driving strategy with drives that did not do all laps; a sentence
    for the others.
    """
    for strategy in DRIVING:
        drives = [
            drive
            for step in experiment.steps.values()
            for drive in step.drives
            if drive.strategy == strategy
        ]
        if any(map(_failed, drives)):
            header = ["Left the road", "Stopped on the road"]
            titles = [f"{title}, {strategy}" for title in header]
            yield table(["Run", "Iteration", *titles], list(_rows(experiment, strategy)))
        elif drives:
            yield f"All {strategy} drives did {LAPS:g} laps."


def _rows(experiment: Experiment, strategy: Strategy) -> Iterator[list[str]]:
    """Of each run and iteration that has such drives."""
    for run in experiment.runs:
        for iteration in experiment.iterations(run):
            steps = experiment.of(run, iteration)
            groups = [[d for s in steps for d in s.drives_of(strategy, c)] for c in CONDITIONS]
            if any(_failed(drive) for drives in groups for drive in drives):
                ends = [_counts(groups, ending) for ending in (left_the_road, stopped_short)]
                yield [RUNS[run], str(iteration), *ends]


def _failed(drive: Outcome) -> bool:
    return left_the_road(drive) or stopped_short(drive)


def _counts(groups: list[list[Outcome]], ending: Callable[[Outcome], bool]) -> str:
    """Without and with traffic."""
    return " / ".join(
        f"{sum(map(ending, drives))} of {len(drives)}" if drives else NOTHING for drives in groups
    )
