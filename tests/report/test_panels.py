"""A panel shows what its lines are, where they are, with intervals, and gaps where there is nothing."""

import matplotlib
import numpy as np
import pytest

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import Experiment
from pipeline.inspection.canvas import png
from pipeline.report.figures import cost, driving, takeover
from pipeline.report.looks import of_key
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import (
    FRAMES,
    GROWING,
    NOTHING,
    SLOW,
    STRATEGIES,
    VARIANTS,
    experiment,
    redriven,
)
from tests.report.drawn import curves, panels


def test_traffic_is_dashed_and_its_markers_are_open(whole: Experiment) -> None:
    shown = panels(takeover(whole, STRATEGIES))
    for title, dashed in (("Takeover: safe, no traffic", False), ("Takeover: safe, traffic", True)):
        for line in shown[title, "iteration"].get_lines():
            assert line.is_dashed() == dashed
            assert (line.get_markerfacecolor() == "white") == dashed


def test_intervals_are_drawn_where_the_points_are(whole: Experiment) -> None:
    axes = panels(driving(whole, STRATEGIES))["Laps: naive, traffic", "iteration"]
    (line,) = (line for line in axes.get_lines() if line.get_label() == "DAgger")
    (bars,) = (bars for bars in axes.collections if bars.get_transform() == line.get_transform())
    found = [
        estimate(whole, "laps", Cell("dagger", (i,), Strategy.NAIVE, ("traffic",)))
        for i in range(4)
    ]
    assert [path.vertices.tolist() for path in bars.get_paths()] == [
        [[i, one.low], [i, one.high]] for i, one in enumerate(found) if one
    ]
    assert all(one and one.low < one.high for one in found)


def test_every_line_has_its_own_place_in_the_panel(whole: Experiment) -> None:
    """Lines that coincide are drawn beside each other, though their points are the data's."""
    axes = panels(driving(whole, STRATEGIES))["Laps: safe, no traffic", "iteration"]
    lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    places = [line.get_transform().transform((1.0, 3.0))[0] for line in lines]
    assert len(lines) == 4
    assert min(np.diff(places)) > 2


def test_what_a_line_cost_is_where_it_is_on_x(whole: Experiment) -> None:
    """No line looks cheaper than one that asked as often; equal points are above each other."""
    for axes in panels(cost(whole, STRATEGIES)).values():
        lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
        places = np.array([line.get_transform().transform((3000.0, 3.0)) for line in lines])
        assert len(lines) == 4 and np.ptp(places[:, 0]) == pytest.approx(0, abs=1e-6)
        assert max(np.diff(places[:, 1])) < -2


def test_the_scale_of_the_queries_has_room_for_none_and_grows_by_factors() -> None:
    axes = panels(cost(experiment({"dagger": SLOW, "safedagger": GROWING}), STRATEGIES))[
        "Laps: naive, traffic", "queries of the loop so far, log scale"
    ]
    nothing, first, double, four = axes.transData.transform(
        [(x, 1.0) for x in (0, 3000, 6000, 12_000)]
    )[:, 0]
    assert nothing < first
    assert double - first == pytest.approx(four - double)
    assert [*axes.get_xticks()] == [0, 3000, 10_000, 35_000]


def test_runs_of_different_length_share_a_panel() -> None:
    axes = panels(takeover(experiment({"dagger": SLOW[:2], "safedagger": GROWING}), STRATEGIES))
    points = curves(axes["Takeover: safe, no traffic", "iteration"])
    assert {run: len(line) for run, line in points.items()} == {"SafeDAgger": 4, "DAgger": 2}
    assert [*axes["Takeover: safe, no traffic", "iteration"].get_xticks()] == [0, 1, 2, 3]


def test_what_is_not_defined_leaves_a_gap() -> None:
    """The primary never drives in iteration 1, and nowhere under the safe strategy."""

    none = {"primary_frames": 0, "deviation_sum": 0.0, "takeover_frames": FRAMES}
    idle = redriven(experiment({"dagger": SLOW}), none, strategy="safe")
    figure = driving(redriven(idle, none, iteration=1), STRATEGIES)
    shown = panels(figure)
    naive = curves(shown["Steering MSE: naive, no traffic", "iteration"])["DAgger"]
    assert [np.isnan(y) for _, y in naive] == [False, True, False, False]
    safe = curves(shown["Steering MSE: safe, no traffic", "iteration"])["DAgger"]
    assert all(np.isnan(y) for _, y in safe)
    assert png(figure)


def test_lines_of_a_panel_differ_in_marker_and_brightness() -> None:
    """At least 8 of the 100 steps of CIELAB's L*, and for grey prints as many."""
    for runs in (STRATEGIES, VARIANTS, (Strategy.SAFE, Strategy.OPTIMAL)):
        looks = [of_key(NOTHING, run)[1:] for run in runs]
        assert len({marker for _, marker in looks}) == len(runs)
        levels = sorted(_brightness(colour) for colour, _ in looks)
        assert min(np.diff(levels)) >= 8


def _brightness(colour: str) -> float:
    """L* of a colour, 0 to 100."""
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    luminance = float(linear @ [0.2126, 0.7152, 0.0722])
    return 116 * np.cbrt(luminance) - 16 if luminance > 0.008856 else 903.3 * luminance
