"""The figures show what the experiment has, where it is, and nothing else."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.evaluation.experiment import ROLLOUT, Experiment
from pipeline.inspection.canvas import png
from pipeline.report.figures import (
    TITLES as FIGURES,
)
from pipeline.report.figures import (
    calibration,
    cost,
    driving,
    optimal,
    over_the_iterations,
    pooled,
    result,
    takeover,
)
from tests.evaluation.made_up import (
    FULL,
    GOOD,
    GROWING,
    NOTHING,
    SLOW,
    SPECS,
    STRATEGIES,
    TITLES,
    VARIANTS,
    experiment,
    reckoned,
    redriven,
    undriven,
    with_optimal,
)
from tests.report.drawn import curves, names, panels, words

DRAW: dict[str, Callable[[Experiment], Figure | None]] = {
    "driving": partial(driving, runs=STRATEGIES),
    "variants": partial(driving, runs=VARIANTS),
    "takeover": partial(takeover, runs=STRATEGIES),
    "cost": partial(cost, runs=STRATEGIES),
    "optimal": optimal,
    "result": result,
}


@pytest.mark.parametrize("name", DRAW)
def test_equal_experiments_give_equal_bytes_and_leave_no_style(
    name: str, whole: Experiment
) -> None:
    before = dict(matplotlib.rcParams)
    first, second = DRAW[name](whole), DRAW[name](whole)
    assert png(first) == png(second)
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize("name", DRAW)
def test_no_text_is_cut_off_or_in_the_way(name: str, whole: Experiment) -> None:
    figure = DRAW[name](whole)
    png(figure)
    width, height = figure.canvas.get_width_height()
    renderer = figure.canvas.get_renderer()
    parts = [*figure.axes, *figure.legends, *figure.texts]
    boxes = [part.get_tightbbox(renderer) for part in parts]
    for i, box in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert not any(box.overlaps(other) for other in boxes[i + 1 :])
    for axes in figure.axes:
        labels = [label.get_window_extent() for label in axes.get_xticklabels()]
        assert all(left.x1 < right.x0 for left, right in pairwise(labels))


@pytest.mark.parametrize("name", DRAW)
def test_every_panel_has_its_labels_and_every_line_its_legend(name: str, whole: Experiment) -> None:
    figure = DRAW[name](whole)
    for axes in panels(figure).values():
        assert axes.get_title(loc="left") and axes.get_xlabel() and axes.get_ylabel()
    shown = {str(line.get_label()) for axes in figure.axes for line in axes.get_lines()}
    explained = {text.get_text() for text in figure.legends[0].get_texts()}
    assert explained == {label for label in shown if not label.startswith("_")} | {
        "no traffic",
        "traffic",
        "95 % interval",
    }


def test_the_result_shows_laps_against_queries_and_the_takeover() -> None:
    """Of SafeDAgger alone, and beside DAgger."""
    alone = panels(result(experiment({"safedagger": GROWING})))
    assert list(alone) == [
        ("Laps: naive, traffic", "queries of the loop so far, log scale"),
        ("Laps: naive, no traffic", "queries of the loop so far, log scale"),
        ("Takeover: safe, no traffic", "iteration"),
        ("Takeover: safe, traffic", "iteration"),
    ]
    in_traffic, laps, alone_on_the_road, takeovers = (curves(axes) for axes in alone.values())
    assert laps == {"SafeDAgger": [(0, 2.0), (3000, 2.5), (6000, 3.0), (7000, 3.0)]}
    assert [y for _, y in in_traffic["SafeDAgger (traffic)"]] == [1.5, 2.0, 2.8, 3.0]
    assert [y for _, y in alone_on_the_road["SafeDAgger"]] == [0.08, 0.05, 0.04, 0.02]
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
    judged = whole.quality.assign(calibration=[[[0.1, 0.2, 30.0]]] * len(whole.quality))
    assert names(replace(whole, quality=judged)) == FIGURES.keys()


def test_driving_has_a_line_for_each_run_with_its_metric() -> None:
    figure = driving(experiment({"dagger": SLOW, "safedagger": GROWING}), STRATEGIES)
    shown = panels(figure)
    metrics = ("Laps: naive", "Steering MSE: naive", "Steering MSE: safe")
    assert [title for title, _ in shown] == [
        f"{each}, {where}" for each in metrics for where in ("no traffic", "traffic")
    ]
    assert words(figure) == (
        "Not drawn, as nothing differs. Damage per lap 0: naive, no traffic; naive, traffic; safe, no traffic; "
        "safe, traffic. Laps 3.00: safe, no traffic; safe, traffic."
    )
    assert curves(shown["Laps: naive, no traffic", "iteration"]) == {
        "SafeDAgger": [(0, 2.0), (1, 2.5), (2, 3.0), (3, 3.0)],
        "DAgger": [(0, 2.0), (1, 2.1), (2, 2.3), (3, 2.4)],
    }
    errors = curves(shown["Steering MSE: naive, traffic", "iteration"])
    assert [y for _, y in errors["SafeDAgger (traffic)"]] == [0.03, 0.02, 0.01, 0.006]


def test_a_panel_is_drawn_as_soon_as_one_drive_differs() -> None:
    """In one iteration of one run, by a hundredth of a lap."""

    one = {"strategy": "safe", "condition": "no_traffic", "start": 0, "scenario": "yew"}
    made_up = experiment({"dagger": SLOW, "safedagger": GROWING})
    slower = redriven(made_up, {"laps": 2.99}, run="dagger", iteration=2, **one)
    figure = driving(slower, STRATEGIES)
    assert ("Laps: safe, no traffic", "iteration") in panels(figure)
    assert words(figure).endswith("Laps 3.00: safe, traffic.")


def test_where_nothing_differs_in_any_panel_all_are_drawn() -> None:
    figure = result(experiment({"safedagger": [FULL] * 4}))
    assert len(panels(figure)) == 4
    assert words(figure) == ""


def test_damage_is_shown_per_lap() -> None:
    damage = {"damage": lambda drives: drives.iteration * drives.laps}
    hit = redriven(experiment({"dagger": SLOW}), damage)
    for where in ("no traffic", "traffic"):
        (points,) = curves(
            panels(driving(hit, STRATEGIES))[f"Damage per lap: naive, {where}", "iteration"]
        ).values()
        assert [y for _, y in points] == [0.0, 1.0, 2.0, 3.0]


def test_takeover_is_that_of_the_safe_strategy() -> None:
    shown = panels(takeover(experiment({"safedagger_max": GROWING}), VARIANTS))
    points = curves(shown["Takeover: safe, traffic", "iteration"])[
        f"{TITLES['safedagger_max']} (traffic)"
    ]
    assert points == [(0, 0.2), (1, 0.15), (2, 0.1), (3, 0.05)]


def test_laps_stand_over_the_mean_cost_of_the_seeds() -> None:
    made_up = experiment({"dagger": SLOW}, seeds=2)

    dearer = {
        "queries": lambda of: of.queries + 1000 * of.seed * of.iteration,
        "frames_trained": lambda of: 2000 + 100 * of.iteration + 200 * of.seed,
    }
    shown = panels(cost(reckoned(made_up, dearer), STRATEGIES))
    asked = curves(shown["Laps: naive, no traffic", "queries of the loop so far, log scale"])[
        "DAgger"
    ]
    assert [x for x, _ in asked] == [0, 15_500, 31_500, 38_000]
    trained = curves(shown["Laps: naive, no traffic", "frames trained on"])["DAgger"]
    assert [x for x, _ in trained] == [2100, 2200, 2300, 2400]
    assert [y for _, y in trained] == [y for _, y in asked] == [2.0, 2.1, 2.3, 2.4]


def test_the_optimal_safety_policy_is_shown_beside_the_learned_ones(whole: Experiment) -> None:
    shown = panels(optimal(whole))
    runs = [run for run in SPECS if run not in VARIANTS[1:]]
    assert [title for title, _ in shown] == [
        f"{metric}: {TITLES[run]}, {where}"
        for run in runs
        for metric in ("Takeover", "Laps")
        for where in ("no traffic", "traffic")
    ]
    for where, dashed in (("no traffic", ""), ("traffic", " (traffic)")):
        points = curves(shown[f"Takeover: SafeDAgger, {where}", "iteration"])
        assert points.keys() == {f"safe{dashed}", f"optimal{dashed}"}
        learned, best = (np.array(points[each + dashed])[:, 1] for each in ("safe", "optimal"))
        assert best == pytest.approx(learned / 2, rel=0.05)


def test_only_what_is_there_is_drawn() -> None:
    """One run of two iterations, in which nobody met traffic."""
    alone = undriven(experiment({"supervised": SLOW[:2]}, starts=1), condition="traffic")
    figures = [driving(alone, STRATEGIES), takeover(alone, STRATEGIES), cost(alone, STRATEGIES)]
    assert [len(panels(figure)) for figure in figures] == [3, 1, 2]
    for figure in figures:
        for axes in panels(figure).values():
            assert [len(points) for points in curves(axes).values()] == [2]
        assert png(figure)


def test_there_is_no_figure_of_nothing() -> None:
    made_up = experiment({"dagger": SLOW})
    assert driving(made_up, VARIANTS) is None
    assert takeover(made_up, ()) is None
    assert cost(NOTHING, STRATEGIES) is None
    assert optimal(made_up) is None


def test_the_optimal_safety_policy_of_iteration_0_alone_is_no_row() -> None:
    """That iteration is other runs', too."""
    made_up = with_optimal(experiment({"safedagger_rising": GROWING}))
    first = undriven(made_up, strategy="optimal", iteration=[1, 2, 3])
    assert optimal(first) is None


def test_the_panel_that_matters_names_its_lines_and_where_they_were_full_first() -> None:
    figure = result(experiment({"safedagger": GROWING, "dagger": SLOW}))
    first, *others = figure.axes
    assert first.get_position().width > 1.5 * others[0].get_position().width
    found = names(first)
    assert found.keys() == {"SafeDAgger: 3 laps at 7,000", "DAgger"}
    assert not any(axes.texts for axes in others)
    above, below = (found[name] for name in ("SafeDAgger: 3 laps at 7,000", "DAgger"))
    assert above.y0 >= below.y1 and above.x0 > first.bbox.x1 and above.x1 < figure.bbox.x1


def test_older_metrics_have_no_picture() -> None:
    assert calibration(experiment(GOOD)) is None


def test_each_iteration_has_a_line_on_what_was_measured() -> None:
    bins = [[0.1, 0.2, 30.0], [0.6, 0.5, 10.0]]
    made_up = experiment(GOOD)
    rows = made_up.quality.assign(judged_on=ROLLOUT, calibration=[bins] * len(made_up.quality))
    figure = calibration(replace(made_up, quality=rows))
    assert figure is not None
    held_out, rollout = figure.axes
    assert len(held_out.get_lines()) == 1  # the diagonal
    _, *lines = rollout.get_lines()
    assert [line.get_label() for line in lines] == [f"iteration {i}" for i in range(4)]
    assert list(lines[0].get_ydata()) == [0.2, 0.5]


def test_bins_of_several_seeds_are_those_of_all_their_frames() -> None:
    found = pooled([[[0.12, 0.0, 10], [0.95, 1.0, 5]], [[0.18, 0.5, 30], [1.0, 0.0, 5]]])
    assert found == [pytest.approx([0.165, 0.375, 40]), pytest.approx([0.975, 0.5, 10])]
