"""The picture of the label curves: how reliable each strategy makes the primary, with how many labels."""

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from pipeline.claims.labels import MARGIN
from pipeline.evaluation.curves import budget, ended, families, last, success
from pipeline.evaluation.experiment import Experiment, mean
from pipeline.inspection.canvas import new_figure
from pipeline.metric import SPENT
from pipeline.report.looks import draw_estimates, label, look, name_ends
from pipeline.report.panels import APART

BAND = 0.15
"""opacity of what counts as as reliable"""


def label_curves(curves: Experiment, best: str) -> Figure:
    """Success against the labels in the loop, a panel for each condition; what lacks at most the margin
    to `best` is in the band. Dots stand a little apart, so that equal ones stay visible.
    """
    with new_figure(10.0, 3.0 * len(curves.conditions) + 0.5) as figure:
        for number, where in enumerate(curves.conditions, 1):
            axes = figure.add_subplot(len(curves.conditions), 1, number)
            _panel(axes, curves, best, where)
        band = f"at most {100 * MARGIN:g} points below {curves.title(best)}"
        there = Patch(color=curves.specs[best].colour, alpha=BAND, label=band)
        handles = [
            *([there] if best in ended(curves) else []),
            Line2D([], [], color="0.4", marker="|", ms=12, linestyle="", label="95 % interval"),
        ]
        figure.legend(handles=handles, loc="outside upper center", ncols=2)
    return figure


def _panel(axes: Axes, curves: Experiment, best: str, where: str) -> None:
    ways = families(curves)
    ends: list[tuple[float, float, str, str]] = []
    for number, (name, family) in enumerate(ways.items()):
        spec = curves.specs[family[0]]
        found = {run: success(curves, run, last(curves, run), where) for run in family}
        values = {run: one for run, one in found.items() if one}
        points = [(_labels(curves, run), one) for run, one in values.items()]
        if spec.collects:
            points = [(x, one) for x, one in points if x > 0]  # else nobody has counted them yet
            shift = APART * (number - (len(ways) - 1) / 2)
            x, drawn = [x for x, _ in points], [one for _, one in points]
            style = look(spec.colour, spec.marker, where)
            draw_estimates(axes, x, drawn, name, style, shift)
            ends += [(x, one.value, name, spec.colour) for x, one in points[-1:]]
        else:
            for _, one in points:
                axes.axhline(one.value, color=spec.colour, linestyle=":", label=name)
                ends.append((math.inf, one.value, name, spec.colour))
        if best in values:
            top = values[best].value
            axes.axhspan(top - MARGIN, top, color=spec.colour, alpha=BAND, linewidth=0)
    axes.set_xscale("log")
    axes.set_xticks(sorted({budget(curves, run) for run in curves.specs} - {0}))
    axes.minorticks_off()
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.grid(axis="y")
    axes.margins(x=0.1)
    axes.set(
        title=f"Success: naive, {label(where)}",
        xlabel="labels in the loop, log scale",
        ylabel="share of drives",
    )
    right = axes.get_xlim()[1]
    name_ends(axes, [(min(x, right), y, name, colour) for x, y, name, colour in ends])


def _labels(curves: Experiment, run: str) -> float:
    """In its loop, the mean over the seeds; as told where no ledger is there."""
    asked = mean(curves.spent, SPENT["queries"], run=run, iteration=last(curves, run))
    return budget(curves, run) if asked is None else asked
