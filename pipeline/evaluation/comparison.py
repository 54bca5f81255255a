"""The metrics of an experiment's cells with their intervals, and the differences between cells.

What is resampled is a *situation*: a seed, a test track and a start. Policies that are compared
meet the same situations.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pandas as pd

from pipeline.driving.metrics import METRICS
from pipeline.evaluation import statistics
from pipeline.evaluation.drives import SITUATION, column
from pipeline.evaluation.experiment import Tables
from pipeline.evaluation.statistics import Estimate, interquartile_mean, ratio_of_sums
from pipeline.metric import Metric
from pipeline.rollout.strategies import Strategy

RESAMPLING_SEED = 0
"""of every interval, so that none depends on which others were asked for"""

KEPT = 512
"""resampled intervals that are not resampled again: tables, figures and claims ask for the same"""

_SITUATION = ["seed", *SITUATION]


STATISTICS = {"ratio of sums": ratio_of_sums, "interquartile mean": interquartile_mean}
"""Of `metric.Metric`."""


@dataclass(frozen=True)
class Cell:
    """Drives of one run and driving strategy, on all seeds.

    Several iterations or conditions are averaged in each situation, which must be in all of them.
    """

    run: str
    """one of the experiment's"""
    iterations: tuple[int, ...]
    strategy: Strategy
    conditions: tuple[str, ...]
    """of the experiment's"""


def naive(experiment: Tables, run: str, iteration: int, *conditions: str) -> Cell:
    """The naive drives of a run after an iteration, in some conditions, or in all together."""
    return Cell(run, (iteration,), Strategy.NAIVE, conditions or tuple(experiment.conditions))


@dataclass(frozen=True)
class Contrast:
    """A metric in two cells, over the situations that both have."""

    value: float
    baseline: float
    difference: Estimate
    """`value` minus `baseline`, paired"""
    most: float = math.inf
    """what the metric can be at most"""


@lru_cache(KEPT)
def estimate(experiment: Tables, metric: str, cell: Cell) -> Estimate | None:
    """One of METRICS in a cell; None where there are no such drives or it is not defined. ValueError for
    two drives of one situation.
    """
    found = _columns(experiment, METRICS[metric], cell)
    if found.empty:
        return None
    return statistics.estimate(
        STATISTICS[METRICS[metric].statistic],
        found.to_numpy(),
        _strata(found.index),
        np.random.default_rng(RESAMPLING_SEED),
    )


@lru_cache(KEPT)
def contrast(experiment: Tables, metric: str, cell: Cell, baseline: Cell) -> Contrast | None:
    """One of METRICS in a cell against another; None where they share no situation or it is not
    defined. ValueError for two drives of one situation.
    """
    statistic = STATISTICS[METRICS[metric].statistic]
    first, second = (_columns(experiment, METRICS[metric], each) for each in (cell, baseline))
    shared = first.index.intersection(second.index).sort_values()
    if shared.empty:
        return None
    columns, others = (each.loc[shared].to_numpy() for each in (first, second))
    difference = statistics.difference(
        statistic, columns, others, _strata(shared), np.random.default_rng(RESAMPLING_SEED)
    )
    if difference is None:
        return None
    once = np.ones((1, len(shared)), dtype=int)
    value, against = (float(statistic(each, once)[0]) for each in (columns, others))
    return Contrast(value, against, difference, experiment.most(METRICS[metric]))


def _columns(experiment: Tables, metric: Metric, cell: Cell) -> pd.DataFrame:
    """What the metric takes of each situation, in order: means over the iterations and conditions."""
    if experiment.drives.empty:
        return pd.DataFrame()
    found = experiment.among(
        run=cell.run,
        iteration=cell.iterations,
        strategy=cell.strategy,
        condition=cell.conditions,
    )
    twice = found[found.duplicated([*_SITUATION, "iteration", "condition"])]
    if not twice.empty:
        drive = twice.iloc[0]
        raise ValueError(
            f"seed {drive.seed}, {cell.run}, iteration {drive.iteration}: two drives of "
            f"{drive.strategy}, {drive.condition}, {drive.scenario}, start {drive.start}, "
            "expected one"
        )
    taken = found.assign(_part=column(found, metric.part), _whole=column(found, metric.whole))
    situations = taken.groupby(_SITUATION)[["_part", "_whole"]]
    complete = situations.size() == len(cell.iterations) * len(cell.conditions)
    return situations.mean()[complete]


def _strata(situations: pd.Index) -> list[tuple[int, str]]:
    """Seed and scenario of each."""
    return [(seed, scenario) for seed, scenario, _ in situations]
