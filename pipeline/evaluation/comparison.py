"""The metrics of an experiment's cells with their intervals, and the differences between cells.

What is resampled is a *situation*: a seed, a test track and a start. Policies that are compared
meet the same situations.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.evaluation import statistics
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.outcomes import Outcome
from pipeline.evaluation.statistics import (
    Estimate,
    Statistic,
    interquartile_mean,
    ratio_of_sums,
)
from pipeline.evaluation.summary import LAPS, condition
from pipeline.rollout.strategies import Strategy

RESAMPLING_SEED = 0
"""of every interval, so that none depends on which others were asked for"""

type Situation = tuple[int, str, int]
"""seed, track, start"""


@dataclass(frozen=True)
class Metric:
    """A statistic, and what it takes of a drive."""

    statistic: Statistic
    columns: Callable[[Outcome], tuple[float, ...]]


METRICS = {
    "laps": Metric(ratio_of_sums, lambda drive: (min(drive.laps, LAPS), 1)),
    "laps_iqm": Metric(interquartile_mean, lambda drive: (min(drive.laps, LAPS),)),
    "damage_per_lap": Metric(ratio_of_sums, lambda drive: (drive.damage, drive.laps)),
    "steering_mse": Metric(
        ratio_of_sums, lambda drive: (drive.squared_error_sum, drive.primary_frames)
    ),
    "takeover": Metric(ratio_of_sums, lambda drive: (drive.takeover_frames, drive.frames)),
    "takeover_length": Metric(
        ratio_of_sums, lambda drive: (drive.takeover_frames, drive.takeovers)
    ),
    "switches_per_lap": Metric(ratio_of_sums, lambda drive: (drive.switches, drive.laps)),
}
"""Those of `Performance`, by their names there, and the interquartile mean of the laps."""


@dataclass(frozen=True)
class Cell:
    """Drives of one run and driving strategy, on all seeds.

    Several iterations or conditions are averaged in each situation, which must be in all of them.
    """

    run: str
    """one of RUNS"""
    iterations: tuple[int, ...]
    strategy: Strategy
    conditions: tuple[str, ...]
    """of CONDITIONS"""


@dataclass(frozen=True)
class Contrast:
    """A metric in two cells, over the situations that both have."""

    value: float
    baseline: float
    difference: Estimate
    """`value` minus `baseline`, paired"""


def estimate(experiment: Experiment, metric: str, cell: Cell) -> Estimate | None:
    """One of METRICS in a cell; None where there are no such drives or it is not defined.

    Raises:
        ValueError: two drives of one situation.
    """
    found = _columns(experiment, METRICS[metric], cell)
    if not found:
        return None
    return statistics.estimate(
        METRICS[metric].statistic,
        np.array([found[situation] for situation in sorted(found)]),
        [(seed, track) for seed, track, _ in sorted(found)],
        np.random.default_rng(RESAMPLING_SEED),
    )


def contrast(experiment: Experiment, metric: str, cell: Cell, baseline: Cell) -> Contrast | None:
    """One of METRICS in a cell against another; None where they share no situation or it is not
    defined.

    Raises:
        ValueError: two drives of one situation.
    """
    statistic = METRICS[metric].statistic
    first, second = (_columns(experiment, METRICS[metric], each) for each in (cell, baseline))
    shared = sorted(first.keys() & second.keys())
    if not shared:
        return None
    columns, others = (np.array([each[s] for s in shared]) for each in (first, second))
    difference = statistics.difference(
        statistic,
        columns,
        others,
        [(seed, track) for seed, track, _ in shared],
        np.random.default_rng(RESAMPLING_SEED),
    )
    if difference is None:
        return None
    once = np.ones((1, len(shared)), dtype=int)
    value, against = (float(statistic(each, once)[0]) for each in (columns, others))
    return Contrast(value, against, difference)


def _columns(experiment: Experiment, metric: Metric, cell: Cell) -> dict[Situation, np.ndarray]:
    """What the metric takes of each situation, (K,): the mean over the iterations and conditions."""
    found: dict[Situation, dict[tuple[int, str], tuple[float, ...]]] = defaultdict(dict)
    for iteration in cell.iterations:
        for step in experiment.of(cell.run, iteration):
            for drive in step.drives:
                where = condition(drive)
                if drive.strategy != cell.strategy or where not in cell.conditions:
                    continue
                rows = found[step.seed, drive.track, drive.start]
                if (iteration, where) in rows:
                    raise ValueError(
                        f"seed {step.seed}, {cell.run}, iteration {iteration}: two drives of "
                        f"{drive.strategy}, {where}, {drive.track}, start {drive.start}, "
                        "expected one"
                    )
                rows[iteration, where] = metric.columns(drive)
    complete = len(cell.iterations) * len(cell.conditions)
    return {
        situation: np.mean(list(rows.values()), axis=0)
        for situation, rows in found.items()
        if len(rows) == complete
    }
