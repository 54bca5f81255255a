"""From evaluated drives to the metrics of Sec. 4.4."""

import math
from collections.abc import Mapping

import pandas as pd

from pipeline.evaluation.drives import column
from pipeline.metric import Metric, shown


def measure(drives: pd.DataFrame, metrics: Mapping[str, Metric]) -> dict[str, float | None]:
    """The metrics that are ratios, of some drives, whose order does not matter; None where there is
    nothing to divide by. ValueError where there are no drives.
    """
    if drives.empty:
        raise ValueError("there are no drives, expected at least one")
    ratios = {n: each for n, each in metrics.items() if each.statistic == "ratio of sums"}
    return {name: _ratio(drives, metric) for name, metric in ratios.items()}


def headline(
    drives: pd.DataFrame, metrics: Mapping[str, Metric]
) -> dict[str, dict[str, float | None]]:
    """What `dvc metrics` shows of drives, over all conditions: {"naive": {"laps": ...}}. Of policies
    only: the optimal strategy is none that one could have.
    """
    return {
        strategy: measure(
            drives[drives.strategy == strategy],
            {n: each for n, each in shown(metrics, "dvc").items() if strategy in each.strategies},
        )
        for strategy in ("naive", "safe")
        if strategy in set(drives.strategy)
    }


def _ratio(drives: pd.DataFrame, metric: Metric) -> float | None:
    # fsum is exact, so that the order of the drives cannot show in the last digit
    part, whole = (math.fsum(column(drives, each)) for each in (metric.part, metric.whole))
    return part / whole if whole > 0 and not math.isnan(part) else None
