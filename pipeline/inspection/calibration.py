"""How probable a safety policy calls unsafe, and how often it is: a line for each set of frames."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

LARGEST = 120.0  # [points squared] of the marker of a bin that has all frames


def draw_calibration(axes: Axes, sets: Mapping[str, Sequence[Sequence[float]]]) -> None:
    """Draw the bins of each set of frames; the more of its frames are in one, the larger its marker.

    Args:
        axes: to draw in.
        sets: by name, of each bin [predicted, observed, frames], see `learning.quality.calibration`.
    """
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=0.8)
    for name, bins in sets.items():
        predicted, observed, frames = zip(*bins, strict=True)
        (line,) = axes.plot(predicted, observed, label=name)
        sizes = [LARGEST * many / sum(frames) for many in frames]
        axes.scatter(predicted, observed, sizes, color=line.get_color(), zorder=3)
    axes.set(
        xlabel="predicted probability of unsafe", ylabel="share unsafe", xlim=(0, 1), ylim=(0, 1)
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.grid()
    if sets:
        axes.legend(loc="upper left")
