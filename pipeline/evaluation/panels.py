"""Panels of a figure: a metric of several runs, with 95 % intervals; gaps where there are none."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter
from matplotlib.transforms import offset_copy

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.inspection.canvas import new_figure, styled
from pipeline.policies.strategies import Strategy

# colours that the colour-blind can tell, of different brightness within a panel, and markers
LOOKS = {
    "supervised": ("black", "D"),
    "dagger": ("#d55e00", "o"),
    "dagger_budget": ("#e69f00", "^"),
    "safedagger": ("#0b4f8a", "s"),
    "safedagger_last": ("#1a8a5a", "<"),
    "safedagger_max": ("#cc79a7", ">"),
    "safedagger_rising": ("#88ccee", "v"),
    Strategy.SAFE: ("#0b4f8a", "s"),
    Strategy.OPTIMAL: ("#e69f00", "D"),
}
DASHES = {"no_traffic": "-", "traffic": (0, (4, 2))}
LABELS = {"no_traffic": "no traffic", "traffic": "traffic"}
NAMES = RUNS | {Strategy.SAFE: "safe", Strategy.OPTIMAL: "optimal"}  # in the legend
TITLES = {
    "laps": ("Laps", "laps"),
    "damage_per_lap": ("Damage", "m²/s² per lap"),
    "steering_mse": ("Steering MSE", "squared error, full lock = 1"),
    "takeover": ("Takeover", "share of frames"),
}
"""Of a metric: its title, and that of its axis."""
ASKED = "queries of the loop so far, log scale"
PLACES: dict[str, Callable[[Experiment, Step], float]] = {
    "iteration": lambda _, step: step.iteration,
    ASKED: lambda experiment, step: experiment.queries(step.seed, step.run, step.iteration),
    "frames trained on": lambda _, step: step.ledger.frames_trained,
}
"""Where on x a step is; over several seeds, the mean."""
SIZE = 5.0  # [points] of a marker
# So that equal points stay visible, [points]: over the iterations, lines stand apart in x. Where x
# is a cost, only intervals do, since no line may look cheaper: earlier ones have larger markers.
APART = 3.0
LARGER = 1.7


@dataclass(frozen=True)
class Line:
    """A run under one driving strategy and condition, over its iterations."""

    run: str
    strategy: Strategy
    condition: str
    key: str
    """of LOOKS: what its colour and marker stand for"""

    def cells(self, experiment: Experiment) -> list[Cell]:
        """Of every iteration that the run has."""
        where = (self.condition,)
        return [Cell(self.run, (i,), self.strategy, where) for i in experiment.iterations(self.run)]


@dataclass(frozen=True)
class Panel:
    """A metric, one of TITLES, of several lines against one of PLACES."""

    title: str
    metric: str
    lines: Sequence[Line]
    place: str = "iteration"


def draw(experiment: Experiment, panels: Sequence[Panel], columns: int) -> Figure | None:
    """The panels that have something to show, row by row; None where none has."""
    drawn = [[line for line in panel.lines if is_driven(experiment, line)] for panel in panels]
    shown = [(panel, lines) for panel, lines in zip(panels, drawn, strict=True) if lines]
    if not shown:
        return None
    rows = -(-len(shown) // columns)
    with styled():
        figure = new_figure(10.0, 2.5 * rows + 0.8)
        for number, (panel, lines) in enumerate(shown, 1):
            axes = figure.add_subplot(rows, columns, number)
            for place, line in enumerate(lines):
                before, after = place, len(lines) - 1 - place
                _draw(axes, experiment, panel, line, APART * (before - after) / 2, after)
            _frame(axes, panel)
        handles = _legend([line for _, lines in shown for line in lines])
        figure.legend(handles=handles, loc="outside upper center", ncols=4, handlelength=3.2)
    return figure


def is_driven(experiment: Experiment, line: Line) -> bool:
    """Whether there is anything to show of it."""
    return any(estimate(experiment, "laps", cell) for cell in line.cells(experiment))


def _draw(
    axes: Axes, experiment: Experiment, panel: Panel, line: Line, shift: float, after: int
) -> None:
    """Values and intervals, `shift` [points] to the right; a gap where there are none. So many lines
    come `after` it.
    """
    found = [estimate(experiment, panel.metric, cell) for cell in line.cells(experiment)]
    value, low, high = (
        [getattr(one, end) if one else np.nan for one in found] for end in ("value", "low", "high")
    )
    steps = [experiment.of(line.run, i) for i in experiment.iterations(line.run)]
    x = [np.mean([PLACES[panel.place](experiment, step) for step in seeds]) for seeds in steps]
    look = _look(*LOOKS[line.key], line.condition)
    is_cost = panel.place != "iteration"
    if is_cost:
        look["markersize"] += LARGER * after
    curve = axes.plot(x, value, label=NAMES[line.key], clip_on=False, zorder=3, **look)
    bars = axes.vlines(x, low, high, look["color"], linewidth=0.9, clip_on=False)
    aside = offset_copy(axes.transData, axes.get_figure(root=True), shift, units="points")
    moved = [bars] if is_cost else [*curve, bars]
    for artist in moved:  # only now: the limits of the axes are those of the data
        artist.set_transform(aside)


def _frame(axes: Axes, panel: Panel) -> None:
    words, unit = TITLES[panel.metric]
    axes.set(title=f"{words}: {panel.title}", xlabel=panel.place, ylabel=unit)
    axes.grid(axis="y")
    axes.margins(x=0.08)
    places = sorted({float(x) for line in axes.get_lines() for x in np.asarray(line.get_xdata())})
    if panel.place == "iteration":
        axes.set_xticks(places)
    elif panel.place == ASKED:  # beyond the first queries: iteration 0 has none
        first = next((x for x in places if x > 0), 1.0)
        axes.set_xscale("symlog", linthresh=first, linscale=0.3)
        axes.set_xticks([0, *_apart(first, places[-1])])
        axes.minorticks_off()
    axes.xaxis.set_major_formatter("{x:,.0f}")
    if panel.metric == "takeover":
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    if panel.metric == "laps":
        axes.axhline(LAPS, color="0.6", linewidth=0.8)
    top = LAPS if panel.metric == "laps" else axes.dataLim.y1
    axes.set_ylim(0, 1.08 * top if top > 0 else 1.0)  # nothing but gaps: minus infinity


def _apart(first: float, last: float) -> list[float]:
    """Round numbers between two on a log scale, and these two, as far as their labels have room."""
    factor = max(1.5, (last / first) ** 0.3)
    ticks = [first]
    for x in (digit * 10**power for power in range(9) for digit in (1, 2, 5)):
        if factor * ticks[-1] <= x <= last / factor:
            ticks.append(x)
    return [*ticks, last] if factor * ticks[-1] <= last else ticks


def _look(colour: str, marker: str, where: str) -> dict[str, Any]:
    look = {"color": colour, "marker": marker, "markersize": SIZE, "linestyle": DASHES[where]}
    return look | {"markerfacecolor": colour if where == "no_traffic" else "white"}


def _legend(lines: Sequence[Line]) -> list[Line2D]:
    """What colours, dashes and bars stand for."""
    keys = dict.fromkeys(line.key for line in lines)
    return [
        *(Line2D([], [], label=NAMES[key], **_look(*LOOKS[key], "no_traffic")) for key in keys),
        *(Line2D([], [], label=LABELS[c], **_look("0.4", "o", c)) for c in CONDITIONS),
        Line2D([], [], color="0.4", marker="|", ms=12, linestyle="", label="95 % interval"),
    ]
