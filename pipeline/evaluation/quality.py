"""What was measured of safety policies, as a table and as a picture."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from pipeline.evaluation.wording import count, table, written
from pipeline.inspection.calibration import draw_calibration
from pipeline.inspection.canvas import new_figure, styled
from pipeline.metric import QUALITY


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
    with styled():
        figure = new_figure(4.6, 4.4)
        draw_calibration(
            figure.subplots(),
            {
                f"{row['dataset']}: error {written(error, row[error.part])}": row["calibration"]
                for row in rows
            },
        )
    return figure
