"""The paper's Fig. 2: how far a primary is from the reference, frame by frame, and where tau lies.

In the shapes, N is the number of frames.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from numpy.typing import NDArray

from pipeline.inspection.canvas import new_figure

LOWEST, HIGHEST = -9.0, 1.0  # of log10 of the deviation; what is beyond counts at the edge
BINS = 50
# outlines of different brightness, so that neither hides the other
LOOKS = (("#0b4f8a", "-", 1.8), ("#d55e00", "--", 1.8))


def error_summary(deviation: NDArray[np.floating], tau: float) -> dict[str, float]:
    """Of deviations [N], for `dvc metrics`; ValueError where there are no frames."""
    if len(deviation) == 0:
        raise ValueError("there are no frames, expected at least one")
    return {
        "frames": float(len(deviation)),
        "share_safe": float((deviation <= tau).mean()),
        "mean": float(deviation.mean()),
        "median": float(np.median(deviation)),
    }


def error_histogram(
    deviations: Mapping[str, NDArray[np.floating]], tau: float, measure: str
) -> Figure:
    """Histograms of log10 of the deviations [N], by a measure of `registry.MEASURES`, of one or two
    named sets of frames, and tau. ValueError for no set, too many, or one without frames.
    """
    if not 1 <= len(deviations) <= len(LOOKS):
        raise ValueError(f"there are {len(deviations)} sets, expected 1 to {len(LOOKS)}")
    with new_figure(5.6, 3.6) as figure:
        axes = figure.subplots()
        for (name, deviation), (colour, line, width) in zip(
            deviations.items(), LOOKS, strict=False
        ):
            safe = error_summary(deviation, tau)["share_safe"]
            logs = np.log10(np.clip(deviation, 10**LOWEST, 10**HIGHEST))
            axes.hist(
                logs,
                bins=np.linspace(LOWEST, HIGHEST, BINS + 1).tolist(),
                weights=np.full(len(logs), 1 / len(logs)),
                histtype="step",
                color=colour,
                linestyle=line,
                linewidth=width,
                label=f"{name}: {100 * safe:.1f} % safe",
            )
        axes.axvline(np.log10(tau), color="black", linewidth=1.0, linestyle=(0, (2, 2)))
        axes.annotate(
            f" tau = {tau:g}",
            (np.log10(tau), 0.97),
            xycoords=("data", "axes fraction"),
            va="top",
        )
        axes.set(xlabel=f"log10 of the deviation ({measure})", ylabel="share of the frames")
        axes.set_xlim(LOWEST, HIGHEST)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        axes.grid(axis="y")
        axes.legend(loc="upper left")
    return figure
