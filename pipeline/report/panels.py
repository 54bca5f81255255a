"""Panels of a figure: a metric of several runs, with 95 % intervals; gaps where there are none."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import Estimate
from pipeline.evaluation.wording import written
from pipeline.inspection.canvas import new_figure
from pipeline.metric import SPENT
from pipeline.report.looks import draw_estimates, legend, look, name_ends, of_key
from pipeline.rollout.strategies import Strategy

# So that equal points stay visible, [points]: over the iterations, lines stand apart in x. Where x
# is a cost, only intervals do, since no line may look cheaper: lines stand apart in y, a little less.
APART = 3.0
LESS = 0.6
WIDTH = 150  # [characters] of a line of text below the panels


@dataclass(frozen=True)
class Line:
    """A run under one driving strategy and condition, over its iterations."""

    run: str
    strategy: Strategy
    condition: str
    key: str
    """what its colour and marker stand for, see `looks.of_key`"""

    def cells(self, experiment: Experiment) -> list[Cell]:
        """Of every iteration that the run has."""
        where = (self.condition,)
        return [Cell(self.run, (i,), self.strategy, where) for i in experiment.iterations(self.run)]


@dataclass(frozen=True)
class Panel:
    """A metric, one of METRICS, of several lines over the iterations, or against what they cost: one of
    SPENT, on the mean over the seeds."""

    title: str
    metric: str
    lines: Sequence[Line]
    place: str = "iteration"
    is_wide: bool = False
    """takes a row, with the names of its lines in the last column: what matters most"""


type Curves = dict[Line, list[Estimate | None]]
"""What is shown of each line, for each of its iterations"""


def draw(experiment: Experiment, panels: Sequence[Panel], columns: int) -> Figure | None:
    """The panels in which something differs, row by row, and the others named below them; all where
    nothing differs in any; None where there is nothing to show.
    """
    driven: list[tuple[Panel, Curves]] = []
    for panel in panels:
        curves = {
            line: [estimate(experiment, panel.metric, cell) for cell in line.cells(experiment)]
            for line in panel.lines
            if _is_driven(experiment, line)
        }
        if curves:
            driven.append((panel, curves))
    if not driven:
        return None
    alike = [_everywhere(curves) for _, curves in driven]
    if None not in alike:
        alike = [None] * len(driven)
    shown = [each for each, value in zip(driven, alike, strict=True) if value is None]
    same = [(each[0], v) for each, v in zip(driven, alike, strict=True) if v is not None]
    widths = [columns if panel.is_wide else 1 for panel, _ in shown]
    rows = -(-sum(widths) // columns)
    with new_figure(10.0, 2.5 * rows + 0.8) as figure:
        for (panel, curves), width, end in zip(shown, widths, accumulate(widths), strict=True):
            axes = figure.add_subplot(rows, columns, (end - width + 1, end - panel.is_wide))
            for number, (line, found) in enumerate(curves.items()):
                shift = APART * (number - (len(curves) - 1) / 2)
                _draw(axes, experiment, panel, line, found, shift)
            most = experiment.most(METRICS[panel.metric])
            _frame(axes, panel, most)
            if panel.is_wide:
                name_ends(
                    axes, [_end(line, panel, most) for line in axes.get_lines()[: len(curves)]]
                )
                for name in axes.texts:  # the panels below may be as wide
                    name.set_in_layout(False)
        handles = legend(experiment, (line.key for _, curves in shown for line in curves))
        figure.legend(handles=handles, loc="outside upper center", ncols=4, handlelength=3.2)
        if same:
            text = fill(f"Not drawn, as nothing differs. {_named(same)}", WIDTH)
            figure.supxlabel(text, x=0.01, ha="left", fontsize="medium")
    return figure


def _is_driven(experiment: Experiment, line: Line) -> bool:
    """Whether there is anything to show of it."""
    return line.run in experiment.runs and not (
        experiment.among(run=line.run, strategy=line.strategy, condition=line.condition).empty
    )


def _named(panels: Iterable[tuple[Panel, float]]) -> str:
    """Panels by what is everywhere in them."""
    titles: dict[str, list[str]] = defaultdict(list)
    for panel, value in panels:
        metric = METRICS[panel.metric]
        words = f"{metric.title} {written(metric, value)}"
        titles[words].append(panel.title)
    return " ".join(f"{words}: {'; '.join(found)}." for words, found in titles.items())


def _everywhere(curves: Curves) -> float | None:
    """What all values and ends of intervals are; None where they differ, or one is missing."""
    found = [one for curve in curves.values() for one in curve]
    ends = {end for one in found if one for end in (one.low, one.value, one.high)}
    return ends.pop() if len(ends) == 1 and None not in found else None


def _draw(
    axes: Axes,
    experiment: Experiment,
    panel: Panel,
    line: Line,
    found: Sequence[Estimate | None],
    shift: float,
) -> None:
    """Values and intervals, by `shift` [points] apart; a gap where there are none."""
    is_cost = panel.place != "iteration"
    rows = among(experiment.spent, run=line.run).groupby("iteration", as_index=False)
    x = rows[panel.place].mean()[panel.place] if is_cost else experiment.iterations(line.run)
    name, colour, marker = of_key(experiment, line.key)
    style = look(colour, marker, line.condition)
    line_aside = (0.0, -LESS * shift) if is_cost else None
    draw_estimates(axes, x, found, name, style, shift, line_aside)


def _end(line: Line2D, panel: Panel, most: float) -> tuple[float, float, str, str]:
    """Where a line ends, its name, where it was first at the most that can be, and its colour."""
    x, y = (np.asarray(values, float) for values in line.get_data())
    full = x[y >= most]
    when = f": {most:g} {METRICS[panel.metric].unit} at {full[0]:,.0f}" if len(full) else ""
    return x[-1], y[-1], f"{line.get_label()}{when}", str(line.get_color())


def _frame(axes: Axes, panel: Panel, most: float) -> None:
    """Labels and limits; `most` is what the metric can be."""
    metric = METRICS[panel.metric]
    axes.set(title=f"{metric.title}: {panel.title}", xlabel=_place(panel), ylabel=metric.unit)
    axes.grid(axis="y")
    axes.margins(x=0.08)
    places = sorted({float(x) for line in axes.get_lines() for x in np.asarray(line.get_xdata())})
    if panel.place == "iteration":
        axes.set_xticks(places)
    elif panel.place == "queries":  # beyond the first queries: iteration 0 has none
        first = next((x for x in places if x > 0), 1.0)
        axes.set_xscale("symlog", linthresh=first, linscale=0.3)
        axes.set_xticks([0, *_apart(first, places[-1])])
        axes.minorticks_off()
    axes.xaxis.set_major_formatter("{x:,.0f}")
    if metric.form == "share":
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    if np.isfinite(most):
        axes.axhline(most, color="0.6", linewidth=0.8)
    top = most if np.isfinite(most) else axes.dataLim.y1
    axes.set_ylim(0, 1.08 * top if top > 0 else 1.0)  # nothing but gaps: minus infinity


def _place(panel: Panel) -> str:
    """What is on x."""
    if panel.place == "iteration":
        return panel.place
    return SPENT[panel.place].unit + (", log scale" if panel.place == "queries" else "")


def _apart(first: float, last: float) -> list[float]:
    """Round numbers between two on a log scale, and these two, as far as their labels have room."""
    factor = max(1.5, (last / first) ** 0.3)
    ticks = [first]
    for x in (digit * 10**power for power in range(9) for digit in (1, 2, 5)):
        if factor * ticks[-1] <= x <= last / factor:
            ticks.append(x)
    return [*ticks, last] if factor * ticks[-1] <= last else ticks
