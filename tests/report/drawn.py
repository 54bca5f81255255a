"""What a figure shows, read back from its axes."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox


def panels(figure: Figure | None) -> dict[tuple[str, str], Axes]:
    """By title and what is on x."""
    return {(axes.get_title(loc="left"), axes.get_xlabel()): axes for axes in figure.axes}


def words(figure: Figure | None) -> str:
    """The text below the panels, in one line."""
    return " ".join(text.get_text().replace("\n", " ") for text in figure.texts)


def curves(axes: Axes) -> dict[str, list[tuple[float, float]]]:
    """Points, by the run or strategy that they are of; with traffic in brackets."""
    return {
        f"{line.get_label()}{' (traffic)' if line.is_dashed() else ''}": list(
            zip(
                np.asarray(line.get_xdata(), float).round(9).tolist(),
                np.asarray(line.get_ydata(), float).round(9).tolist(),
                strict=True,
            )
        )
        for line in axes.get_lines()
        if not str(line.get_label()).startswith("_")
    }


def names(axes: Axes) -> dict[str, Bbox]:
    """Where the names of the lines stand, without what leads to them."""
    figure = axes.get_figure(root=True)
    figure.canvas.draw()
    return {text.get_text(): Text.get_window_extent(text) for text in axes.texts}
