import numpy as np
import pytest

from pipeline.driving.deviation import steering, steering_and_brake

PROPOSED = np.array([[0.1, 0.0], [-1.0, 1.0], [0.5, 1.0]], np.float32)
REFERENCE = np.array([[0.1, 1.0], [1.0, 1.0], [0.45, 0.0]], np.float32)


def test_the_deviation_is_the_squared_difference_of_the_steering():
    epsilon = steering(PROPOSED, REFERENCE)
    assert epsilon.dtype == np.float64
    assert epsilon == pytest.approx([0, 4, 0.0025])


def test_a_wrong_brake_counts_only_when_asked_for():
    assert steering_and_brake(PROPOSED, REFERENCE) == pytest.approx([1, 4, 1.0025])


def test_actions_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"expected the same \(frames, 2\)"):
        steering(PROPOSED[:, 0], REFERENCE[:, 0])
