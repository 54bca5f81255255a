import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pipeline.data.schema import Asked
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.rules.audit import Audit
from pipeline.rollout.rules.calm import Calm
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.optimal import Optimal
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.rule import Decision, Rule, Signals
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import DRIVING, parse_driving

shares = st.floats(0, 1)
known = st.one_of(shares, st.just(math.nan))
STEERING = Judgement(0.5, 0.0, "steering").deviation


def decide(rule: Rule, safe_probability: float = math.nan, apart: float = 0.0) -> Decision:
    """What a rule says where the two steerings are so far apart."""
    primary, reference = np.float32([apart, 0]), np.float32([0, 0])
    return rule.decide(Signals(primary, {"safe_probability": safe_probability}, reference))


@given(known, st.floats(0, 2))
def test_reference_always_drives_in_reference_and_never_in_naive(
    safe_probability: float, apart: float
) -> None:
    assert decide(Reference(), safe_probability, apart) == Decision(True, Asked.DROVE, 1)
    assert decide(Naive(), safe_probability, apart) == Decision(False, Asked.NOT, 0)


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
    decision = decide(Safe(cut), safe_probability)
    assert (decision.reference_drives, decision.asked is Asked.DROVE) == (drives, drives)


@given(shares)
def test_a_safety_policy_that_answers_nan_is_not_trusted(cut: float) -> None:
    assert decide(Safe(cut), math.nan).reference_drives
    nothing = Signals(np.zeros(2, np.float32), {}, np.zeros(2, np.float32))
    assert Safe(cut).decide(nothing).reference_drives


@pytest.mark.parametrize(("apart", "drives"), [(0.0, False), (0.0499, False), (0.051, True)])
def test_optimal_hands_over_above_the_threshold(apart: float, drives: bool) -> None:
    assert decide(Optimal(0.0025, STEERING), apart=apart).reference_drives is drives


def test_only_the_optimal_rule_must_see_the_reference_first() -> None:
    rules = (Reference(), Naive(), Safe(0.5), Mixture(0.5))
    assert Optimal(0.1, STEERING).looks_up and not any(rule.looks_up for rule in rules)


@given(shares, st.integers(0, 99))
@example(0.0, 0)  # Dagger's default schedule, I(i = 0), from the first iteration on
@example(1.0, 0)
def test_a_mixture_draws_from_its_own_generator_and_always_asks(beta: float, seed: int) -> None:
    rule = Mixture(beta)
    rule.begin(np.random.default_rng(seed))
    draws = np.random.default_rng(seed).random(5)
    for draw in draws:
        decision = decide(rule)
        assert decision.reference_drives is bool(draw < beta)
        assert decision.asked is (Asked.DROVE if draw < beta else Asked.MIXTURE)
        assert decision.ask_probability == 1


@given(shares, shares, st.integers(0, 99))
@example(1.0, 0.5, 0)
@example(0.0, 0.0, 0)
def test_a_mixture_may_ask_about_a_share_of_what_the_primary_drives(
    beta: float, ask: float, seed: int
) -> None:
    """Only asking is left to chance anew: the reference's frames cost a query each."""
    rule = Mixture(beta, ask)
    rule.begin(np.random.default_rng(seed))
    rng = np.random.default_rng(seed)
    for _ in range(5):
        decision = decide(rule)
        if rng.random() < beta:
            assert decision == Decision(True, Asked.DROVE, 1.0)
        else:
            asked = ask == 1 or rng.random() < ask
            assert decision == Decision(False, Asked.MIXTURE if asked else Asked.NOT, ask)


def who(rule: Rule, probabilities: list[float]) -> str:
    """Who drives each frame of a drive: the reference or the primary."""
    rule.begin(np.random.default_rng(0))
    return "".join("R" if decide(rule, each).reference_drives else "p" for each in probabilities)


@pytest.mark.parametrize(
    ("resume", "least", "probabilities", "expected"),
    [
        (0.8, 0, [0.9, 0.5, 0.49, 0.5, 0.79, 0.8, 0.5], "ppRRRpp"),
        (0.5, 3, [0.4, 0.9, 0.9, 0.9, 0.4], "RRRpR"),
        (0.5, 2.5, [0.4, 0.9, 0.9, 0.9], "RRRp"),
        (0.8, 2, [0.4, 0.9, 0.7, 0.9, 0.4, 0.4, 0.9], "RRRpRRp"),
        (0.5, 0, [0.9, math.nan, 0.5], "pRp"),
        (0.5, math.inf, [0.9, 0.4, 0.9, 0.9], "pRRR"),
    ],
)
def test_who_is_calm_hands_back_late(
    resume: float, least: float, probabilities: list[float], expected: str
) -> None:
    rule = Calm(Safe(0.5), resume, least)
    assert who(rule, probabilities) == expected
    assert who(rule, probabilities) == expected, "a drive remembers another"


@given(shares, st.lists(known, max_size=20), shares, st.integers(0, 5))
def test_the_calm_reference_drives_where_it_is_called_and_more(
    cut: float, probabilities: list[float], more: float, least: int
) -> None:
    hasty = who(Safe(cut), probabilities)
    assert who(Calm(Safe(cut), cut, 0), probabilities) == hasty
    calm = who(Calm(Safe(cut), cut + more * (1 - cut), least), probabilities)
    assert all(late == "R" for late, soon in zip(calm, hasty, strict=True) if soon == "R")
    assert calm.count("Rp") <= hasty.count("Rp")
    assert all(len(call) >= least for call in calm.rstrip("R").split("p") if call)


def audited(rule: Rule, share: float, probabilities: list[float]) -> list[Decision]:
    """A drive in which it is audited."""
    rule = Audit(rule, share)
    rule.begin(np.random.default_rng(3))
    return [decide(rule, each) for each in probabilities]


@given(shares, st.lists(known, max_size=20), shares)
def test_who_is_audited_drives_as_nobody_looked(
    cut: float, probabilities: list[float], share: float
) -> None:
    """And where the reference drives, it is asked already."""
    alone = [decide(Safe(cut), each) for each in probabilities]
    for decision, without in zip(audited(Safe(cut), share, probabilities), alone, strict=True):
        assert decision.reference_drives == without.reference_drives
        if decision.reference_drives:
            assert decision == without
        else:
            assert decision.asked in (Asked.NOT, Asked.AUDIT) and decision.ask_probability == share


def test_a_random_share_of_what_the_primary_drives_is_audited_whatever_is_said_of_it() -> None:
    said = [0.6, 0.9] * 10_000
    asked = np.array([each.asked is Asked.AUDIT for each in audited(Safe(0.5), 0.1, said)])
    assert [asked[n::2].mean() for n in (0, 1)] == pytest.approx([0.1, 0.1], abs=0.01)
    assert audited(Safe(0.5), 0, said) == [decide(Safe(0.5), each) for each in said]
    assert {each.asked for each in audited(Safe(0.5), 1, said)} == {Asked.AUDIT}


def test_chance_beneath_an_audit_is_what_it_is_without() -> None:
    class Coin(Mixture):
        def decide(self, signals: Signals) -> Decision:
            drove = super().decide(signals).reference_drives
            return decide(Reference() if drove else Naive())

    alone = Coin(0.5)
    alone.begin(np.random.default_rng(3))
    drove = [decide(alone).reference_drives for _ in range(30)]
    assert [each.reference_drives for each in audited(Coin(0.5), 0.5, [0.0] * 30)] == drove


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Safe(1.1), "cut"),
        (lambda: Optimal(-1.0, STEERING), "tau"),
        (lambda: Mixture(math.nan), "beta"),
        (lambda: Mixture(0.5, 1.1), "ask"),
        (lambda: Audit(Safe(0.5), 1.1), "audit"),
        (lambda: Calm(Safe(0.5), math.nan, 0), "resume"),
        (lambda: Calm(Safe(0.5), 0.5, -1), "least"),
    ],
)
def test_numbers_out_of_range_are_refused(make: object, named: str) -> None:
    with pytest.raises(ValueError, match=f"^{named} is .*, expected a number from 0 to"):
        make()


def test_a_primary_is_evaluated_by_the_strategies_of_the_paper_and_the_optimal_one() -> None:
    assert [parse_driving(name) for name in ("naive", "safe", "optimal")] == list(DRIVING)
    with pytest.raises(ValueError, match="'mixture': expected one of naive, safe, optimal"):
        parse_driving("mixture")


@pytest.mark.parametrize(
    ("numbers", "problem"),
    [
        ((True, Asked.NOT, 1.0), "asked is NOT where the reference drives"),
        ((False, Asked.AUDIT, 1.5), "ask_probability is 1.5, expected a number from 0 to 1"),
        ((False, Asked.NOT, math.nan), "ask_probability is nan"),
    ],
)
def test_a_decision_that_contradicts_itself_is_refused(
    numbers: tuple[bool, Asked, float], problem: str
) -> None:
    with pytest.raises(ValueError, match=problem):
        Decision(*numbers)
