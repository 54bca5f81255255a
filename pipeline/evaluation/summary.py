"""From evaluated drives to the metrics of Sec. 4.4, for JSON and `dvc metrics`."""

import math
from collections.abc import Mapping

import pandas as pd

from pipeline.metric import Metric

LAPS = 3.0
"""A drive is halted after so many laps (Sec. 4.4)."""
CONDITIONS = ("no_traffic", "traffic")
"""Of the car."""

type Performance = dict[str, float | None]
"""By the names of the metrics that are ratios, and of "drives", "frames" and "measuring_queries",
the frames in which the reference was looked up; None where there is nothing to divide by."""


def measure(drives: pd.DataFrame, metrics: Mapping[str, Metric]) -> Performance:
    """The metrics of some drives, of one strategy and condition; their order does not matter.

    Raises:
        ValueError: no drives.
    """
    if drives.empty:
        raise ValueError("there are no drives, expected at least one")
    ratios = {
        name: _ratio(drives, metric)
        for name, metric in metrics.items()
        if metric.statistic == "ratio of sums"
    }
    return {
        **ratios,
        "drives": len(drives),
        "frames": int(drives.frames.sum()),
        "measuring_queries": int(drives.primary_frames[drives.deviation_sum.notna()].sum()),
    }


def summarise(
    drives: pd.DataFrame, metrics: Mapping[str, Metric]
) -> dict[str, dict[str, Performance]]:
    """The metrics by strategy and condition: {"naive": {"no_traffic": {"laps": ...}}}.

    Raises:
        ValueError: no drives.
    """
    if drives.empty:
        raise ValueError("there are no drives, expected at least one")
    return {
        str(strategy): {
            str(condition): measure(group, metrics)
            for condition, group in driven.groupby("condition")
        }
        for strategy, driven in drives.groupby("strategy")
    }


def _ratio(drives: pd.DataFrame, metric: Metric) -> float | None:
    # fsum is exact, so that the order of the drives cannot show in the last digit
    part, whole = (math.fsum(drives[name]) for name in (metric.part, metric.whole))
    return part / whole if whole > 0 and not math.isnan(part) else None
