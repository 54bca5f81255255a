"""How the lines of a figure look, and the legend that says so."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import offset_copy

from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import Estimate
from pipeline.rollout.strategies import Strategy

OF_STRATEGIES = {
    Strategy.SAFE: ("safe", "#0b4f8a", "s"),
    Strategy.OPTIMAL: ("optimal", "#e69f00", "D"),
}
"""Where driving strategies are told apart, not runs: name, colour and marker."""
DASHED = "traffic"
"""the condition whose lines are dashed, with open markers"""
SIZE = 5.0  # [points] of a marker
NAME = 0.07  # [height of a panel] that the name of a line takes


def look(colour: str, marker: str, where: str) -> dict[str, Any]:
    """Of a line in one of the conditions, for matplotlib."""
    dashes, inside = ((0, (4, 2)), "white") if where == DASHED else ("-", colour)
    line = {"color": colour, "marker": marker, "markersize": SIZE, "linestyle": dashes}
    return line | {"markerfacecolor": inside}


def label(where: str) -> str:
    """Of a condition."""
    return where.replace("_", " ")


def of_key(experiment: Experiment, key: str) -> tuple[str, str, str]:
    """Name, colour and marker of a run, or of one of OF_STRATEGIES."""
    if key in OF_STRATEGIES:
        return OF_STRATEGIES[Strategy(key)]
    run = experiment.specs[key]
    return run.name, run.colour, run.marker


def draw_estimates(
    axes: Axes,
    x: Sequence[float],
    found: Sequence[Estimate | None],
    name: str,
    style: Mapping[str, Any],
    shift: float,
    line_aside: tuple[float, float] | None = None,
) -> None:
    """Intervals at `x`, and a line called `name` through their values, gaps where there are none; moved
    by `shift` [points] to the right, the line otherwise if so told. For `style` see `look`.
    """
    value, low, high = (
        [getattr(one, end) if one else np.nan for one in found] for end in ("value", "low", "high")
    )
    (line,) = axes.plot(x, value, label=name, clip_on=False, zorder=3, **style)
    bars = axes.vlines(x, low, high, style["color"], linewidth=0.9, clip_on=False)
    # only now: the limits of the axes are those of the data
    aside, figure = (shift, 0.0), axes.get_figure(root=True)
    for artist, moved in ((bars, aside), (line, line_aside or aside)):
        artist.set_transform(offset_copy(axes.transData, figure, *moved, units="points"))


def name_ends(axes: Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """Write the names of lines beside the panel, apart where their ends coincide; `ends` are where a
    line ends, its name and its colour.
    """
    low, high = axes.get_ylim()
    ordered = sorted(ends, key=lambda end: (end[1], end[0]))
    places = [(y - low) / (high - low) for _, y, *_ in ordered]
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + NAME)
    for i in reversed(range(len(places))):  # none above the panel
        places[i] = min(places[i], 1 - NAME * (len(places) - 1 - i))
    for (x, y, name, colour), place in zip(ordered, places, strict=True):
        line = {"arrowstyle": "-", "color": colour, "linewidth": 0.5, "relpos": (0, 0.5)}
        beside: dict[str, Any] = {"textcoords": "axes fraction", "va": "center"}
        axes.annotate(name, (x, y), (1.04, place), color=colour, arrowprops=line, **beside)


def legend(experiment: Experiment, keys: Iterable[str]) -> list[Line2D]:
    """What colours, dashes and bars stand for: each of the keys, see `of_key`, once."""
    shown = [of_key(experiment, key) for key in dict.fromkeys(keys)]
    return [
        *(Line2D([], [], label=name, **look(colour, marker, "")) for name, colour, marker in shown),
        *(Line2D([], [], label=label(c), **look("0.4", "o", c)) for c in experiment.conditions),
        Line2D([], [], color="0.4", marker="|", ms=12, linestyle="", label="95 % interval"),
    ]
