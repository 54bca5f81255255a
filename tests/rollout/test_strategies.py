import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.rollout.strategies import DRIVING, Rule, Strategy, parse_driving

shares = st.floats(0, 1)
known = st.one_of(shares, st.just(math.nan))


@given(known, st.one_of(st.floats(0, 5), st.just(math.nan)), st.floats(0, 1, exclude_max=True))
def test_reference_always_drives_in_reference_and_never_in_naive(
    safe_probability: float, deviation: float, draw: float
) -> None:
    now = safe_probability, deviation, draw
    assert Rule(Strategy.REFERENCE).reference_drives(*now)
    assert not Rule(Strategy.NAIVE).reference_drives(*now)


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
    rule = Rule(Strategy.SAFE, cut=cut)
    assert rule.reference_drives(safe_probability, math.nan, 0.0) is drives


@given(shares)
def test_a_safety_policy_that_answers_nan_is_not_trusted(cut: float) -> None:
    assert Rule(Strategy.SAFE, cut=cut).reference_drives(math.nan, 0.0, 0.0)


@pytest.mark.parametrize(("deviation", "drives"), [(0.0, False), (0.0025, False), (0.0026, True)])
def test_optimal_hands_over_above_the_threshold(deviation: float, drives: bool) -> None:
    rule = Rule(Strategy.OPTIMAL, tau=0.0025)
    assert rule.reference_drives(math.nan, deviation, 0.0) is drives


@given(shares, st.floats(0, 1, exclude_max=True))
def test_a_mixture_draws(beta: float, draw: float) -> None:
    assert Rule(Strategy.MIXTURE, beta=beta).reference_drives(math.nan, 0.0, draw) is (draw < beta)


@given(st.floats(0, 1, exclude_max=True))
def test_a_mixture_without_beta_is_naive_and_with_all_of_it_the_reference(draw: float) -> None:
    """Dagger's default schedule, I(i = 0), from the first iteration on: the primary alone."""
    assert not Rule(Strategy.MIXTURE, beta=0.0).reference_drives(math.nan, 0.0, draw)
    assert Rule(Strategy.MIXTURE, beta=1.0).reference_drives(math.nan, 0.0, draw)


@pytest.mark.parametrize("change", [{"cut": 1.1}, {"tau": -1.0}, {"beta": math.nan}])
def test_numbers_out_of_range_are_refused(change: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        Rule(Strategy.SAFE, **change)


def test_a_primary_is_evaluated_by_the_strategies_of_the_paper_and_the_optimal_one() -> None:
    assert [parse_driving(name) for name in ("naive", "safe", "optimal")] == list(DRIVING)
    with pytest.raises(ValueError, match="'mixture': expected one of naive, safe, optimal"):
        parse_driving("mixture")
