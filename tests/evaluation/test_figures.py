"""The figure over the iterations: every panel shows what it says, and the bytes are stable."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

from pipeline.evaluation.figures import progress
from pipeline.evaluation.results import STRATEGIES, Results, read_results
from pipeline.evaluation.summary import CONDITIONS
from pipeline.inspection.canvas import png
from tests.evaluation.sample import GOOD, write_run


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return read_results(write_run(tmp_path_factory.mktemp("metrics")), 3)


def test_equal_results_give_equal_bytes(results: Results) -> None:
    assert png(progress(results)) == png(progress(results))


def test_the_style_is_not_left_behind(results: Results) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    png(progress(results))
    assert dict(matplotlib.rcParams) == before


def test_no_panel_is_empty_and_each_has_its_labels(results: Results) -> None:
    figure = progress(results)
    assert len(figure.axes) == 6
    for axes in figure.axes:
        assert axes.get_title(loc="left")
        assert axes.get_xlabel() == "iteration"
        assert axes.get_ylabel()
        assert _points(axes) >= len(results.iterations)


def test_no_text_is_cut_off_or_in_the_way(results: Results) -> None:
    figure = progress(results)
    png(figure)
    width, height = figure.canvas.get_width_height()
    boxes = [part.get_tightbbox() for part in [*figure.axes, *figure.legends]]
    for i, box in enumerate(boxes):
        assert box is not None
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert not any(other is not None and box.overlaps(other) for other in boxes[i + 1 :])


def test_the_laps_panel_shows_the_laps(results: Results) -> None:
    lines = progress(results).axes[0].get_lines()[1:]  # the first marks three laps
    shown = {tuple(np.asarray(line.get_ydata(), float)) for line in lines}
    assert shown == {
        tuple(step.driving[strategy][where].laps for step in results.iterations)
        for strategy in STRATEGIES
        for where in CONDITIONS
    }


def test_what_is_not_defined_leaves_a_gap(tmp_path: Path) -> None:
    plan = {**GOOD, ("safe", 0): ((0.0, 0, 1.0), *GOOD["safe", 0][1:])}
    plan["safe", 0] = tuple((max(laps, 0.01), d, 1.0) for laps, d, _ in plan["safe", 0])
    figure = progress(read_results(write_run(tmp_path, plan), 3))
    errors = [line.get_ydata() for line in figure.axes[2].get_lines()]
    assert any(np.isnan(np.asarray(line, float)).all() for line in errors)
    assert png(figure)


def _points(axes: Axes) -> int:
    """Points on curves, and bars with a height."""
    curves = sum(int(np.isfinite(np.asarray(line.get_ydata(), float)).sum()) for line in axes.lines)
    bars = sum(patch.get_height() > 0 for patch in axes.patches)  # type: ignore[attr-defined]
    return curves + bars
