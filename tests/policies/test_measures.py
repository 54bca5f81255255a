import numpy as np
import pytest

from pipeline.driving.deviation import steering
from pipeline.policies.measures import load_measure, mean_square
from pipeline.registry import MEASURES


def test_the_mean_square_is_over_the_numbers_of_an_action() -> None:
    proposed = np.array([[1, 2, 3], [0, 0, np.nan]], np.float32)
    epsilon = mean_square(proposed, np.zeros((2, 3), np.float32))
    assert epsilon.dtype == np.float32
    np.testing.assert_allclose(epsilon, [14 / 3, np.nan])
    with pytest.raises(ValueError, match="expected the same"):
        mean_square(proposed, proposed[:1])


def test_a_measure_has_a_name() -> None:
    assert load_measure("steering") is steering
    assert load_measure("pipeline.policies.measures:mean_square") is mean_square
    assert all(callable(load_measure(name)) for name in MEASURES)
    with pytest.raises(ValueError, match="measure 'throttle': expected one of mean-square, "):
        load_measure("throttle")
