import numpy as np
import pytest

from pipeline.evaluation.errors import error_histogram, error_summary

TAU = 0.0025
HALF = np.array([1e-4, TAU, 0.01, 4.0], np.float32)


def test_safe_is_up_to_the_threshold_itself() -> None:
    summary = error_summary(HALF.astype(float), TAU)
    assert summary["share_safe"] == 0.5
    assert summary["frames"] == 4
    assert summary["median"] == pytest.approx((TAU + 0.01) / 2)


def test_no_frames_no_summary() -> None:
    with pytest.raises(ValueError, match="no frames"):
        error_summary(np.array([]), TAU)


def test_every_frame_is_drawn_even_those_without_any_error() -> None:
    """log10 of 0 is minus infinity: it counts at the edge."""
    figure = error_histogram({"trained on": np.zeros(3), "held out": HALF}, TAU, "steering")
    (axes,) = figure.axes
    for patch in axes.patches:
        heights = patch.get_xy()[:, 1]
        assert heights[1::2].sum() == pytest.approx(1)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert sorted(labels) == ["held out: 50.0 % safe", "trained on: 100.0 % safe"]
    assert axes.lines[0].get_xdata()[0] == pytest.approx(np.log10(TAU))


@pytest.mark.parametrize("sets", [{}, {name: HALF for name in "abc"}])
def test_one_or_two_sets_are_compared(sets: dict) -> None:
    with pytest.raises(ValueError, match=f"there are {len(sets)} sets, expected 1 to 2"):
        error_histogram(sets, TAU, "steering")
