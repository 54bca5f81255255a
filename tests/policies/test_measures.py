import numpy as np
import pytest

from pipeline.policies.measures import deviation, half_range, mean_square
from pipeline.registry import MEASURES


def test_the_mean_square_is_over_the_numbers_of_an_action() -> None:
    proposed = np.array([[1, 2, 3], [0, 0, np.nan]], np.float32)
    epsilon = mean_square(proposed, np.zeros((2, 3), np.float32), np.ones(3))
    np.testing.assert_allclose(epsilon, [14 / 3, np.nan])
    for other, halves in ((proposed[:1], np.ones(3)), (proposed, np.ones(2))):
        with pytest.raises(ValueError, match="expected the same"):
            mean_square(proposed, other, halves)


def test_numbers_of_any_unit_count_alike() -> None:
    """From one end of its range to the other is 4, whether these are degrees or metres."""
    joints = {"shape": (2,), "low": [-180.0, 0.0], "high": [180.0, 0.1]}
    low, high = np.array([joints["low"]], "f4"), np.array([joints["high"]], "f4")
    halves = half_range(joints)
    assert deviation("mean-square", low, high, halves) == pytest.approx([4.0])
    one = np.array([[180.0, 0.0]], "f4")
    assert deviation("mean-square", low, one, halves) == pytest.approx([2.0])


def test_without_bounds_numbers_are_from_minus_1_to_1() -> None:
    assert half_range({"shape": (3,), "names": None}) == [1.0, 1.0, 1.0]
    pair = np.zeros((1, 3), "f4"), np.ones((1, 3), "f4")
    assert deviation("mean-square", *pair, []) == pytest.approx([1.0])


def test_a_measure_has_a_name() -> None:
    pair = np.zeros((1, 2), "f4"), np.ones((1, 2), "f4")
    found = {name: float(deviation(name, *pair, [1, 0.5])[0]) for name in MEASURES}
    assert found == {"mean-square": 2.5, "steering": 1.0, "steering-and-brake": 2.0}
    assert deviation("pipeline.policies.measures:mean_square", *pair, [1, 1]) == 1.0
    with pytest.raises(ValueError, match="measure 'throttle': expected one of mean-square, "):
        deviation("throttle", *pair, [1, 1])
