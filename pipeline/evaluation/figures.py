"""The run in one figure: how the policies drive and what they cost, over the iterations."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from pipeline.data.ledger import cumulative
from pipeline.evaluation.results import STRATEGIES, Results, SafetyQuality
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.inspection.canvas import new_figure, styled
from pipeline.policies.strategies import Strategy

# colours that the colour-blind can tell, of different brightness, and markers for grey prints;
# the first drawn has the larger marker, so that the second does not hide it
LOOKS = {Strategy.SAFE: ("#0b4f8a", "s", 7.5), Strategy.NAIVE: ("#d55e00", "o", 5.0)}
DASHES = {"no_traffic": "-", "traffic": (0, (4, 2))}
APART = {"no_traffic": -0.06, "traffic": 0.06}  # in x: curves that coincide stay visible
LABELS = {"no_traffic": "no traffic", "traffic": "traffic"}
SMALL_LEGEND: dict[str, Any] = {"fontsize": 8.5, "borderaxespad": 0.1, "columnspacing": 1.2}
QUALITIES = {
    "auroc": ("AUROC", "black", "D"),
    "recall": ("recall", "#009e73", "^"),
    "precision": ("precision", "#cc79a7", "v"),
}


def progress(results: Results) -> Figure:
    """Six panels: laps, damage per lap, steering MSE; takeover share, queries, safety policy."""
    with styled():
        figure = new_figure(10.0, 6.6)
        (laps, damage, error), (takeover, queries, safety) = figure.subplots(2, 3)
        _draw_laps(laps, results)
        _draw_damage(damage, results)
        _draw_error(error, results)
        _draw_takeover(takeover, results)
        _draw_queries(queries, results)
        _draw_safety(safety, results)
        for axes in figure.axes:
            axes.set_xlabel("iteration")
            axes.set_xticks([iteration.number for iteration in results.iterations])
            axes.set_xlim(-0.35, results.last.number + 0.35)
        figure.legend(
            handles=_legend(), loc="outside upper center", ncols=4, fontsize=9.5, handlelength=3.2
        )
    return figure


def _draw_laps(axes: Axes, results: Results) -> None:
    axes.set_title("Distance on the test tracks")
    axes.set_ylabel("laps")
    axes.axhline(LAPS, color="0.6", linewidth=0.8)
    _draw_driving(axes, results, "laps", LOOKS)
    axes.set_ylim(0, 1.08 * LAPS)


def _draw_damage(axes: Axes, results: Results) -> None:
    axes.set_title("Damage per lap")
    axes.set_ylabel("m²/s² per lap")
    _draw_driving(axes, results, "damage_per_lap", LOOKS)
    _from_zero(axes)


def _draw_error(axes: Axes, results: Results) -> None:
    axes.set_title("Steering MSE")
    axes.set_ylabel("squared error, full lock = 1")
    _draw_driving(axes, results, "steering_mse", LOOKS)
    _from_zero(axes)


def _draw_takeover(axes: Axes, results: Results) -> None:
    axes.set_title("Takeover by the reference")
    axes.set_ylabel("share of frames, safe strategy")
    _draw_driving(axes, results, "takeover", (Strategy.SAFE,))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    _from_zero(axes)


def _draw_driving(
    axes: Axes, results: Results, metric: str, strategies: Iterable[Strategy]
) -> None:
    axes.grid(axis="y")
    numbers = np.array([iteration.number for iteration in results.iterations])
    for strategy in strategies:
        for condition in CONDITIONS:
            values = [
                getattr(iteration.driving[strategy][condition], metric)
                for iteration in results.iterations
            ]
            axes.plot(
                numbers + APART[condition],
                np.array(values, dtype=float),
                clip_on=False,
                zorder=3,
                **_look(strategy, condition),
            )


def _look(strategy: Strategy, condition: str) -> dict[str, Any]:
    colour, marker, size = LOOKS[strategy]
    return {
        "color": colour,
        "marker": marker,
        "markersize": size,
        "markerfacecolor": colour if condition == "no_traffic" else "white",
        "linestyle": DASHES[condition],
    }


def _draw_queries(axes: Axes, results: Results) -> None:
    axes.set_title("Queries so far")
    axes.set_ylabel("frames")
    axes.grid(axis="y")
    numbers = [iteration.number for iteration in results.iterations]
    loop = [0, *(total.queries for total in cumulative([step.ledger for step in results.loop]))]
    d_0, d_safe = results.first.ledger.queries, results.d_safe.queries
    axes.bar(numbers, d_0, 0.6, color="0.8", label="$D_0$")
    axes.bar(
        numbers, d_safe, 0.6, d_0, color="white", edgecolor="0.6", hatch="////", label="$D_{safe}$"
    )
    bars = axes.bar(numbers, loop, 0.6, d_0 + d_safe, color="#0b4f8a", label="in the loop")
    axes.bar_label(bars, [f"+{queries:,}" if queries else "" for queries in loop], padding=2)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.set_ylim(0, 1.4 * (d_0 + d_safe + loop[-1]))
    axes.legend(loc="upper left", ncols=2, **SMALL_LEGEND)


def _draw_safety(axes: Axes, results: Results) -> None:
    axes.set_title("Safety policy: unsafe frames")
    axes.set_ylabel("AUROC, recall, precision")
    axes.grid(axis="y")
    numbers = [iteration.number for iteration in results.iterations]
    for metric, (label, colour, marker) in QUALITIES.items():
        held_out = [_value(iteration.held_out, metric) for iteration in results.iterations]
        rollouts = [_value(iteration.next_rollout, metric) for iteration in results.iterations]
        axes.plot(numbers, held_out, color=colour, marker=marker, label=label)
        axes.plot(
            numbers, rollouts, color=colour, marker=marker, linestyle=":", markerfacecolor="white"
        )
    axes.set_ylim(0, 1.4)  # room for the legend
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.legend(
        handles=[
            *axes.get_legend_handles_labels()[0],
            Line2D([], [], color="0.3", label="held-out frames"),
            Line2D([], [], color="0.3", linestyle=":", label="next rollout"),
        ],
        loc="upper left",
        ncols=2,
        **SMALL_LEGEND,
    )


def _value(quality: SafetyQuality | None, metric: str) -> float:
    value = None if quality is None else getattr(quality, metric)
    return np.nan if value is None else value


def _from_zero(axes: Axes) -> None:
    axes.set_ylim(0, max(axes.get_ylim()[1], 1e-3))


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], label=f"{strategy}, {LABELS[condition]}", **_look(strategy, condition))
        for strategy in STRATEGIES
        for condition in CONDITIONS
    ]
