"""What is measured, said once: `evaluate`, DVC, tables, figures, claims and cards ask here."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

DRIVES = "drives"
"""A column of ones: over it, a ratio is the mean over the drives."""
FAILURE = "failures."
"""What the names of a ledger's failures of one kind begin with."""
BINS = 10
"""of equal width, of the probability of being unsafe, in which predicted and observed are compared"""
EVERYWHERE: Final = ("tables", "figures", "cards")


@dataclass(frozen=True)
class Metric:
    """A statistic of one or two columns of a table, how it is written, and where it is shown.

    A column is a name, or an expression of names as `pandas.DataFrame.eval` reads it.
    """

    title: str
    unit: str
    """as on an axis"""
    form: Literal["rounded down", "share", "amount", "ratio", "count"]
    """a name of `evaluation.wording.FORMS`"""
    part: str
    whole: str = DRIVES
    """a drive in which it is 0 counts for nothing; where it is 0 in all, the metric is not defined"""
    statistic: Literal["ratio of sums", "interquartile mean", "mean"] = "ratio of sums"
    """the latter two are of `part` alone"""
    most: str | None = None
    """the task's setting that it cannot exceed"""
    strategies: tuple[str, ...] = ("naive", "safe", "optimal")
    """driving strategies that it tells something of; of no other there are tables"""
    shown: tuple[Literal["tables", "figures", "cards", "dvc"], ...] = EVERYWHERE


def shown(metrics: Mapping[str, Metric], where: str) -> dict[str, Metric]:
    """Those of `metrics` that are shown in tables, figures, on cards or by `dvc metrics`."""
    return {name: metric for name, metric in metrics.items() if where in metric.shown}


DRIVEN: Mapping[str, Metric] = {
    "deviation": Metric(
        "Deviation",
        "epsilon",
        "amount",
        "deviation_sum",
        "primary_frames",
        strategies=("naive", "safe"),
        shown=(*EVERYWHERE, "dvc"),
    ),
    "takeover": Metric(
        "Takeover",
        "share of frames",
        "share",
        "takeover_frames",
        "frames",
        strategies=("safe", "optimal"),
        shown=("tables", "cards", "dvc"),
    ),
    "takeover_length": Metric(
        "Frames of a takeover",
        "frames",
        "amount",
        "takeover_frames",
        "takeovers",
        strategies=("safe", "optimal"),
        shown=("tables",),
    ),
}
"""Of drives, whatever the task."""


def _means(*metrics: Metric) -> dict[str, Metric]:
    """By the name of its part, each as a mean over the rows."""
    return {metric.part: replace(metric, statistic="mean") for metric in metrics}


QUALITY: Mapping[str, Metric] = _means(
    Metric("AUROC", "probability", "ratio", "auroc", shown=("tables", "cards", "dvc")),
    Metric(
        "Recall of unsafe",
        "share of the unsafe",
        "share",
        "recall",
        shown=("tables", "cards", "dvc"),
    ),
    Metric("Precision of unsafe", "share of those called so", "share", "precision"),
    Metric(
        "Average precision",
        "share of those called so",
        "ratio",
        "average_precision",
        shown=("tables",),
    ),
    Metric("Calibration error", "probability", "ratio", "calibration_error", shown=("tables",)),
    Metric("Truly unsafe", "share of frames", "share", "share_unsafe"),
    Metric("Called unsafe", "share of frames", "share", "share_predicted_unsafe"),
)
"""Of a safety policy, in the order of `learning.quality`: how well it finds what is unsafe."""

SPENT: Mapping[str, Metric] = _means(
    Metric(
        "Queries so far",
        "queries of the loop so far",
        "count",
        "queries",
        shown=("tables", "figures", "dvc"),
    ),
    Metric("Labels in all", "labels", "count", "labels"),
    Metric("Frames driven so far", "frames", "count", "frames_driven"),
    Metric("Of them by the reference", "share of frames", "share", "takeover"),
    Metric("Frames trained on", "frames trained on", "count", "frames_trained"),
)
"""Of a loop up to an iteration: what it cost."""

COLLECTED: Mapping[str, Metric] = _means(
    Metric("Drives", "drives", "count", "drives"),
    Metric("Scenarios", "scenarios", "count", "scenarios"),
    Metric("Calls", "calls", "count", "calls"),
    Metric("Frames of a call", "frames", "amount", "call_length"),
    Metric("Switches", "switches", "count", "switches"),
    Metric("Audits", "queries", "count", "audits"),
    # no counts: of one on three seeds, rounding would leave none
    Metric("Put back", "times", "amount", "put_back"),
    Metric(
        "Failures while collecting", "failures", "amount", "failures", shown=(*EVERYWHERE, "dvc")
    ),
)
"""Of the same: what its drives took, and what became of them."""
