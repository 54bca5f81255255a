import math

import pytest

from pipeline.policies.strategies import Strategy, reference_drives

PROBABILITIES = [0.0, 0.2, 0.499, 0.5, 0.8, 1.0, math.nan]


@pytest.mark.parametrize("safe_probability", PROBABILITIES)
def test_reference_always_drives_in_reference_and_never_in_naive(safe_probability: float) -> None:
    assert reference_drives(Strategy.REFERENCE, safe_probability, 0.5)
    assert not reference_drives(Strategy.NAIVE, safe_probability, 0.5)


@pytest.mark.parametrize(
    ("safe_probability", "cut", "drives"),
    [
        (0.0, 0.5, True),
        (0.499, 0.5, True),
        (0.5, 0.5, False),
        (1.0, 0.5, False),
        (0.4, 0.3, False),
        (0.2, 0.3, True),
        (0.0, 0.0, False),
        (0.999, 1.0, True),
    ],
)
def test_safe_hands_over_below_the_cut(safe_probability: float, cut: float, drives: bool) -> None:
    """Eq. 2's polarity: 1 is safe, so a low probability calls the reference."""
    assert reference_drives(Strategy.SAFE, safe_probability, cut) is drives


def test_strategies_are_named_as_in_the_paper() -> None:
    assert [strategy.value for strategy in Strategy] == ["reference", "naive", "safe"]
