"""What drives are measured by. A metric is said once: figures, tables, claims and cards ask here."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

DRIVES = "drives"
"""A column of ones: over it, a ratio is the mean over the drives."""


@dataclass(frozen=True)
class Metric:
    """The ratio of the sums of two columns of a table of drives, and how it is written."""

    title: str
    unit: str
    """as on an axis"""
    form: Literal["rounded down", "share", "amount"]
    """a name of `evaluation.wording.FORMS`"""
    part: str
    whole: str = DRIVES
    """a drive in which it is 0 counts for nothing; where it is 0 in all, the metric is not defined"""
    statistic: Literal["ratio of sums", "interquartile mean"] = "ratio of sums"
    """the latter is of `part` alone"""


DRIVEN: Mapping[str, Metric] = {
    "deviation": Metric("Deviation", "epsilon", "amount", "deviation_sum", "primary_frames"),
    "takeover": Metric("Takeover", "share of frames", "share", "takeover_frames", "frames"),
    "takeover_length": Metric(
        "Frames of a takeover", "frames", "amount", "takeover_frames", "takeovers"
    ),
}
"""Of all drives, whatever the task."""
