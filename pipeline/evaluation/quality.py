"""What was measured of safety policies, as a table and as pictures."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from pipeline.evaluation.wording import count, table, written
from pipeline.inspection.canvas import new_figure
from pipeline.metric import QUALITY

LARGEST = 120.0  # [points squared] of the marker of a bin that has all frames


def quality_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """As markdown; a row has "dataset" and "situation" beside what `learning.quality` finds."""
    header = ["Dataset", "Frames where", "Frames", *(each.title for each in QUALITY.values())]
    cells = [
        [
            row["dataset"],
            row["situation"],
            count(row["frames"]),
            *(written(each, row[each.part]) for each in QUALITY.values()),
        ]
        for row in rows
    ]
    return table(header, cells, words=2)


def calibration_picture(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Predicted against observed, a line for each row with any frames."""
    error = QUALITY["calibration_error"]
    with new_figure(4.6, 4.4) as figure:
        draw_calibration(
            figure.subplots(),
            {
                f"{row['dataset']}: error {written(error, row[error.part])}": row["calibration"]
                for row in rows
            },
        )
    return figure


def draw_calibration(axes: Axes, sets: Mapping[str, Sequence[Sequence[float]]]) -> None:
    """How probable a safety policy calls unsafe, and how often it is: a line for each of the named sets of
    frames, whose bins are [predicted, observed, frames], see `learning.quality.calibration`. The more
    of its frames are in one, the larger its marker.
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
