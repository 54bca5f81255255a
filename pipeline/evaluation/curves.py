"""The label curves: how reliable a primary drives alone, by the labels that it has learned from.

A run is a strategy with a budget, and is compared after its last iteration, when that is spent.
"""

from collections import defaultdict
from functools import partial

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import estimate, naive
from pipeline.evaluation.drives import column
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import Estimate, exact


def ended(curves: Experiment) -> list[str]:
    """The runs whose last iteration was driven, on whatever seed."""
    return [run for run in curves.runs if curves.seeds_of(run, last(curves, run))]


def last(curves: Experiment, run: str) -> int:
    """The iteration after which a run's budget is spent."""
    return curves.specs[run].iterations[-1]


def families(curves: Experiment) -> dict[str, list[str]]:
    """The runs that collect in one way, by what it is called, from few labels to many: a strategy, and
    a protocol where it is not the strategy's first.
    """
    found: dict[str, list[str]] = defaultdict(list)
    usual: dict[str, str] = {}
    there = ended(curves)
    for run, spec in curves.specs.items():
        name = spec.name.partition(",")[0]
        other = spec.protocol != usual.setdefault(name, spec.protocol)
        if run in there:
            found[f"{name}, from {spec.protocol}" if other else name].append(run)
    return {name: sorted(runs, key=partial(budget, curves)) for name, runs in found.items()}


def budget(curves: Experiment, run: str) -> int:
    """The labels in its loop, as it was told; 0 of strategies that are told something else."""
    spec = curves.specs[run]
    return sum(spec.queries or spec.frames)


def yardstick(curves: Experiment) -> str | None:
    """DAgger with the most labels, by which all are measured; None where no run has ended."""
    dagger = [run for run, spec in curves.specs.items() if spec.strategy == "dagger"]
    return max(dagger, key=partial(budget, curves), default=None) if ended(curves) else None


def success(curves: Experiment, run: str, iteration: int, where: str) -> Estimate | None:
    """The share of the drives without a failure: of a single seed exact, over several by bootstrap."""
    drives = curves.among(run=run, iteration=iteration, condition=where)
    if drives.seed.nunique() != 1:
        return estimate(curves, "success", naive(curves, run, iteration, where))
    return exact(int(column(drives, METRICS["success"].part).sum()), len(drives))
