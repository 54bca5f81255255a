"""The figures show what the experiment has, where it is, and nothing else."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import RUNS, TRAINING, VARIANTS, Experiment, Step
from pipeline.evaluation.figures import (
    TITLES,
    cost,
    driving,
    optimal,
    over_the_iterations,
    result,
    takeover,
)
from pipeline.evaluation.panels import LOOKS
from pipeline.evaluation.summary import condition
from pipeline.inspection.canvas import png
from pipeline.policies.strategies import Strategy
from tests.evaluation.made_up import (
    FIRST,
    GOOD,
    GROWING,
    SLOW,
    changed,
    experiment,
    scattered,
)

TABLE = {run: scattered(list(levels)) for run, levels in GOOD.items()}
DRAW: dict[str, Callable[[Experiment], Figure | None]] = {
    "driving": partial(driving, runs=TRAINING),
    "variants": partial(driving, runs=VARIANTS),
    "takeover": partial(takeover, runs=TRAINING),
    "cost": partial(cost, runs=TRAINING),
    "optimal": optimal,
    "result": result,
}


def with_optimal(step: Step) -> Step:
    """Drives like the safe ones, with half of the takeover; not in variants, as in the experiment."""
    if step.run in VARIANTS[1:]:
        return step
    added = [
        replace(
            drive,
            strategy=Strategy.OPTIMAL,
            takeover_frames=drive.takeover_frames // 2,
            primary_frames=drive.frames - drive.takeover_frames // 2,
        )
        for drive in step.drives
        if drive.strategy == Strategy.SAFE
    ]
    return replace(step, drives=step.drives + added)


@pytest.fixture(scope="module")
def whole() -> Experiment:
    """Everything there can be, scattered, on two seeds."""
    return changed(experiment(TABLE, seeds=2, starts=2), with_optimal)


def panels(figure: Figure | None) -> dict[tuple[str, str], Axes]:
    """By title and what is on x."""
    assert figure is not None
    return {(axes.get_title(loc="left"), axes.get_xlabel()): axes for axes in figure.axes}


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


@pytest.mark.parametrize("name", DRAW)
def test_equal_experiments_give_equal_bytes_and_leave_no_style(
    name: str, whole: Experiment
) -> None:
    before = dict(matplotlib.rcParams)
    first, second = DRAW[name](whole), DRAW[name](whole)
    assert first is not None and second is not None
    assert png(first) == png(second)
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize("name", DRAW)
def test_no_text_is_cut_off_or_in_the_way(name: str, whole: Experiment) -> None:
    figure = DRAW[name](whole)
    assert figure is not None
    png(figure)
    width, height = figure.canvas.get_width_height()
    boxes = [part.get_tightbbox() for part in [*figure.axes, *figure.legends]]
    for i, box in enumerate(boxes):
        assert box is not None
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert not any(other is not None and box.overlaps(other) for other in boxes[i + 1 :])
    for axes in figure.axes:
        labels = [label.get_window_extent() for label in axes.get_xticklabels()]
        assert all(left.x1 < right.x0 for left, right in pairwise(labels))


@pytest.mark.parametrize("name", DRAW)
def test_every_panel_has_its_labels_and_every_line_its_legend(name: str, whole: Experiment) -> None:
    figure = DRAW[name](whole)
    for axes in panels(figure).values():
        assert axes.get_title(loc="left") and axes.get_xlabel() and axes.get_ylabel()
    assert figure is not None
    shown = {str(line.get_label()) for axes in figure.axes for line in axes.get_lines()}
    explained = {text.get_text() for text in figure.legends[0].get_texts()}
    assert explained == {label for label in shown if not label.startswith("_")} | {
        "no traffic",
        "traffic",
        "95 % interval",
    }


def test_the_result_shows_laps_against_queries_and_the_takeover_in_traffic() -> None:
    """Of SafeDAgger alone, and beside DAgger."""
    alone = panels(result(experiment({"safedagger": GROWING})))
    assert list(alone) == [
        ("Laps: naive, no traffic", "queries so far, log scale"),
        ("Laps: naive, traffic", "queries so far, log scale"),
        ("Takeover: safe, traffic", "iteration"),
    ]
    laps, in_traffic, takeovers = (curves(axes) for axes in alone.values())
    assert laps == {"SafeDAgger": [(0, 2.0), (3000, 2.5), (6000, 3.0), (7000, 3.0)]}
    assert [y for _, y in in_traffic["SafeDAgger (traffic)"]] == [1.5, 2.0, 2.8, 3.0]
    assert [y for _, y in takeovers["SafeDAgger (traffic)"]] == [0.2, 0.15, 0.1, 0.05]
    both = panels(result(experiment({"safedagger": GROWING, "dagger": SLOW})))
    assert {len(curves(axes)) for axes in both.values()} == {2}
    assert result(experiment({"safedagger_max": GROWING})) is None


def test_over_the_iterations_there_is_what_has_something_to_show(whole: Experiment) -> None:
    def names(made_up: Experiment) -> set[str]:
        return set(over_the_iterations(made_up))

    training = {"strategies", "strategies_takeover", "strategies_cost"}
    assert names(experiment({"safedagger": GROWING}, starts=1)) == training
    assert names(experiment({"dagger": SLOW}, starts=1)) == training
    assert names(whole) == TITLES.keys()


def test_driving_has_a_line_for_each_run_with_its_metric() -> None:
    shown = panels(driving(experiment({"dagger": SLOW, "safedagger": GROWING}), TRAINING))
    assert len(shown) == 2 * 2 * 3
    assert curves(shown["Laps: naive, no traffic", "iteration"]) == {
        "SafeDAgger": [(0, 2.0), (1, 2.5), (2, 3.0), (3, 3.0)],
        "DAgger": [(0, 2.0), (1, 2.1), (2, 2.3), (3, 2.4)],
    }
    errors = curves(shown["Steering MSE: naive, traffic", "iteration"])
    assert [y for _, y in errors["SafeDAgger (traffic)"]] == [0.03, 0.02, 0.01, 0.006]
    assert all(y == 3.0 for _, y in curves(shown["Laps: safe, no traffic", "iteration"])["DAgger"])


def test_traffic_is_dashed_and_its_markers_are_open(whole: Experiment) -> None:
    shown = panels(takeover(whole, TRAINING))
    for title, dashed in (("Takeover: safe, no traffic", False), ("Takeover: safe, traffic", True)):
        for line in shown[title, "iteration"].get_lines():
            assert line.is_dashed() == dashed
            assert (line.get_markerfacecolor() == "white") == dashed


def test_damage_is_shown_per_lap() -> None:
    hit = changed(
        experiment({"dagger": SLOW}),
        lambda step: replace(step, drives=[replace(d, damage=2 * d.laps) for d in step.drives]),
    )
    for where in ("no traffic", "traffic"):
        (points,) = curves(
            panels(driving(hit, TRAINING))[f"Damage: naive, {where}", "iteration"]
        ).values()
        assert [y for _, y in points] == [2.0] * 4


def test_intervals_are_drawn_where_the_points_are(whole: Experiment) -> None:
    axes = panels(driving(whole, TRAINING))["Laps: naive, traffic", "iteration"]
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
    axes = panels(driving(whole, TRAINING))["Laps: safe, no traffic", "iteration"]
    lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    places = [line.get_transform().transform((1.0, 3.0))[0] for line in lines]
    assert len(lines) == 4
    assert min(np.diff(places)) > 2


def test_takeover_is_that_of_the_safe_strategy() -> None:
    shown = panels(takeover(experiment({"safedagger_max": GROWING}), VARIANTS))
    points = curves(shown["Takeover: safe, traffic", "iteration"])[
        f"{RUNS['safedagger_max']} (traffic)"
    ]
    assert points == [(0, 0.2), (1, 0.15), (2, 0.1), (3, 0.05)]


def test_laps_stand_over_the_mean_cost_of_the_seeds() -> None:
    made_up = experiment({"dagger": SLOW}, seeds=2)

    def dearer(step: Step) -> Step:
        queries = step.ledger.queries + 1000 * step.seed * step.iteration
        trained = 2000 + 100 * step.iteration + 200 * step.seed
        return replace(step, ledger=replace(step.ledger, queries=queries, frames_trained=trained))

    shown = panels(cost(changed(made_up, dearer), TRAINING))
    asked = curves(shown["Laps: naive, no traffic", "queries so far, log scale"])["DAgger"]
    assert [x for x, _ in asked] == [0, 15_500, 31_500, 38_000]
    trained = curves(shown["Laps: naive, no traffic", "frames trained on"])["DAgger"]
    assert [x for x, _ in trained] == [2100, 2200, 2300, 2400]
    assert [y for _, y in trained] == [y for _, y in asked] == [2.0, 2.1, 2.3, 2.4]


def test_the_scale_of_the_queries_has_room_for_none_and_grows_by_factors() -> None:
    axes = panels(cost(experiment({"dagger": SLOW, "safedagger": GROWING}), TRAINING))[
        "Laps: naive, traffic", "queries so far, log scale"
    ]
    nothing, first, double, four = axes.transData.transform(
        [(x, 1.0) for x in (0, 3000, 6000, 12_000)]
    )[:, 0]
    assert nothing < first
    assert double - first == pytest.approx(four - double)
    assert [*axes.get_xticks()] == [0, 3000, 10_000, 35_000]


def test_the_optimal_safety_policy_is_shown_beside_the_learned_ones(whole: Experiment) -> None:
    shown = panels(optimal(whole))
    runs = [run for run in RUNS if run not in VARIANTS[1:]]
    assert [title for title, _ in shown] == [
        f"{metric}: {RUNS[run]}" for run in runs for metric in ("Takeover", "Laps")
    ]
    points = curves(shown["Takeover: SafeDAgger", "iteration"])
    assert points.keys() == {"safe", "safe (traffic)", "optimal", "optimal (traffic)"}
    for where in ("", " (traffic)"):
        learned, best = (np.array(points[each + where])[:, 1] for each in ("safe", "optimal"))
        assert best == pytest.approx(learned / 2, rel=0.05)


def test_only_what_is_there_is_drawn() -> None:
    """One run of two iterations, in which nobody met traffic."""
    alone = changed(
        experiment({"supervised": [FIRST, FIRST]}, starts=1),
        lambda step: replace(step, drives=[d for d in step.drives if condition(d) == "no_traffic"]),
    )
    figures = [driving(alone, TRAINING), takeover(alone, TRAINING), cost(alone, TRAINING)]
    assert [len(panels(figure)) for figure in figures] == [6, 1, 2]
    for figure in figures:
        for axes in panels(figure).values():
            assert [len(points) for points in curves(axes).values()] == [2]
        assert figure is not None and png(figure)


def test_runs_of_different_length_share_a_panel() -> None:
    axes = panels(takeover(experiment({"dagger": SLOW[:2], "safedagger": GROWING}), TRAINING))
    points = curves(axes["Takeover: safe, no traffic", "iteration"])
    assert {run: len(line) for run, line in points.items()} == {"SafeDAgger": 4, "DAgger": 2}
    assert [*axes["Takeover: safe, no traffic", "iteration"].get_xticks()] == [0, 1, 2, 3]


def test_there_is_no_figure_of_nothing() -> None:
    made_up = experiment({"dagger": SLOW})
    assert driving(made_up, VARIANTS) is None
    assert takeover(made_up, ()) is None
    assert cost(Experiment({}), TRAINING) is None
    assert optimal(made_up) is None


def test_what_is_not_defined_leaves_a_gap() -> None:
    """The primary never drives in iteration 1, and nowhere under the safe strategy."""

    def idle(step: Step) -> Step:
        none = {"primary_frames": 0, "squared_error_sum": 0.0}
        return replace(
            step,
            drives=[
                replace(d, takeover_frames=d.frames, **none)
                if step.iteration == 1 or d.strategy == Strategy.SAFE
                else d
                for d in step.drives
            ],
        )

    figure = driving(changed(experiment({"dagger": SLOW}), idle), TRAINING)
    shown = panels(figure)
    naive = curves(shown["Steering MSE: naive, no traffic", "iteration"])["DAgger"]
    assert [np.isnan(y) for _, y in naive] == [False, True, False, False]
    safe = curves(shown["Steering MSE: safe, no traffic", "iteration"])["DAgger"]
    assert all(np.isnan(y) for _, y in safe)
    assert figure is not None and png(figure)


def test_lines_of_a_panel_differ_in_marker_and_brightness() -> None:
    """At least 8 of the 100 steps of CIELAB's L*, and for grey prints as many."""
    for runs in (TRAINING, VARIANTS, (Strategy.SAFE, Strategy.OPTIMAL)):
        assert len({LOOKS[run][1] for run in runs}) == len(runs)
        levels = sorted(_brightness(LOOKS[run][0]) for run in runs)
        assert min(np.diff(levels)) >= 8


def _brightness(colour: str) -> float:
    """L* of a colour, 0 to 100."""
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    luminance = float(linear @ [0.2126, 0.7152, 0.0722])
    return 116 * np.cbrt(luminance) - 16 if luminance > 0.008856 else 903.3 * luminance
