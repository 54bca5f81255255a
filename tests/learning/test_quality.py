"""How well unsafe frames are found, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.learning.quality import detection_quality

NAN = float("nan")


def quality(probability: list[float], epsilon: list[float], tau=0.0025, cut=0.5):
    return detection_quality(np.array(probability), np.array(epsilon), tau, cut)


def test_by_hand():
    #      found          missed  false alarm   well left alone
    found = quality([0.1, 0.4, 0.6, 0.3, 0.7, 0.9, 0.8, 0.5], [1, 1, 1, 0, 0, 0, 0, 0.0025])
    assert found == {
        "frames": 8,
        "share_unsafe": 3 / 8,
        "share_predicted_unsafe": 3 / 8,
        "recall": 2 / 3,
        "precision": 2 / 3,
        # Of 15 pairs of unsafe and safe three are in the wrong order: .4 .3, .6 .3 and .6 .5.
        "auroc": pytest.approx(12 / 15),
        # The unsafe ones are first, third and fifth of all.
        "average_precision": pytest.approx((1 / 1 + 2 / 3 + 3 / 5) / 3),
        "calibration_error": pytest.approx((0.1 + 0.2 + 0.3 + 0.6 + 0.5 + 0.4 + 0.7 + 0.1) / 8),
        "calibration": [
            pytest.approx([predicted, observed, 1])
            for predicted, observed in (
                (0.1, 0), (0.2, 0), (0.3, 0), (0.4, 1), (0.5, 0), (0.6, 1), (0.7, 0), (0.9, 1)
            )
        ],
    }  # fmt: skip


def test_the_cut_itself_is_safe_and_the_threshold_too():
    measured = quality([0.5, 0.49], [0.0025, 0.0026])
    assert (measured["recall"], measured["precision"]) == (1, 1)


def test_what_is_not_defined_is_none():
    assert quality([0.9, 0.8], [0, 0]) == {
        "frames": 2,
        "share_unsafe": 0,
        "share_predicted_unsafe": 0,
        "recall": None,
        "precision": None,
        "auroc": None,
        "average_precision": None,
        "calibration_error": pytest.approx(0.15),
        "calibration": [pytest.approx([0.1, 0, 1]), pytest.approx([0.2, 0, 1])],
    }
    assert quality([0.1], [1])["auroc"] is None
    nothing = quality([], [])
    assert nothing.pop("calibration") == []
    assert set(nothing.values()) == {0, None}


def test_frames_without_a_deviation_are_left_out():
    assert quality([0.1, 0.9, 0.2], [1, 0, NAN]) == quality([0.1, 0.9], [1, 0])


def test_a_probability_that_is_no_number_is_the_least_safe():
    assert quality([0.2, NAN, 0.9], [0, 1, 0]) == quality([0.2, 0.0, 0.9], [0, 1, 0])


def test_arrays_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match=r"safe_probability is \(1,\), expected \(2,\)"):
        quality([0.1], [1, 0])


@given(st.lists(st.tuples(st.sampled_from([0.1, 0.3, 0.5, 0.9]), st.booleans()), max_size=20))
def test_the_auroc_is_the_share_of_pairs_in_order(frames):
    unsafe = [p for p, is_unsafe in frames if is_unsafe]
    safe = [p for p, is_unsafe in frames if not is_unsafe]
    found = quality([p for p, _ in frames], [float(u) for _, u in frames])["auroc"]
    pairs = [1.0 if u < s else 0.5 if u == s else 0.0 for u in unsafe for s in safe]
    assert found == (pytest.approx(np.mean(pairs)) if pairs else None)


def test_a_bin_is_its_mean_against_its_share():
    """Three frames in the bin from 0.8 to 0.9 of being unsafe, two of which are; one in the last."""
    found = quality([0.12, 0.15, 0.18, 0.0], [1, 1, 0, 1])
    assert found["calibration"] == [pytest.approx([0.85, 2 / 3, 3]), pytest.approx([1, 1, 1])]
    assert found["calibration_error"] == pytest.approx((0.85 - 2 / 3) * 3 / 4)


@given(st.lists(st.tuples(st.sampled_from([0.1, 0.3, 0.5, 0.9]), st.booleans()), max_size=20))
def test_the_average_precision_is_scikit_learns(frames):
    """The sum of (R_n - R_{n-1}) P_n over the thresholds n, as its `average_precision_score` says."""
    found = quality([p for p, _ in frames], [float(u) for _, u in frames])["average_precision"]
    total = sum(u for _, u in frames)
    before = expected = 0.0
    for threshold in sorted({p for p, _ in frames}):
        called = [u for p, u in frames if p <= threshold]
        recall = sum(called) / total if total else 0.0
        expected += (recall - before) * sum(called) / len(called)
        before = recall
    assert found == (pytest.approx(expected) if total else None)
