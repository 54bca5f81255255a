"""How probable unsafe was, and how often it is: as measured, on the frames of all seeds."""

from dataclasses import replace

import pytest

from pipeline.evaluation.experiment import ROLLOUT
from pipeline.report.calibration import calibration, pooled
from tests.evaluation.made_up import GOOD, experiment


def test_older_metrics_have_no_picture() -> None:
    assert calibration(experiment(GOOD)) is None


def test_each_iteration_has_a_line_on_what_was_measured() -> None:
    bins = [[0.1, 0.2, 30.0], [0.6, 0.5, 10.0]]
    made_up = experiment(GOOD)
    rows = made_up.quality.assign(judged_on=ROLLOUT, calibration=[bins] * len(made_up.quality))
    figure = calibration(replace(made_up, quality=rows))
    held_out, rollout = figure.axes
    assert len(held_out.get_lines()) == 1  # the diagonal
    _, *lines = rollout.get_lines()
    assert [line.get_label() for line in lines] == [f"iteration {i}" for i in range(4)]
    assert list(lines[0].get_ydata()) == [0.2, 0.5]


def test_bins_of_several_seeds_are_those_of_all_their_frames() -> None:
    found = pooled([[[0.12, 0.0, 10], [0.95, 1.0, 5]], [[0.18, 0.5, 30], [1.0, 0.0, 5]]])
    assert found == [pytest.approx([0.165, 0.375, 40]), pytest.approx([0.975, 0.5, 10])]
