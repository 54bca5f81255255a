from dataclasses import replace

import pytest
import torch

from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.task import Driving
from pipeline.evaluation.driving import evaluate, plans
from pipeline.policies.inference import Driver
from pipeline.policies.network import SafetyNetwork
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.plans import Plan
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import DRIVING, Strategy

TRUSTING = Judgement(cut=0.0, tau=9.0, measure="steering")
RULES = [TRUSTING.rule(strategy) for strategy in DRIVING]
ALWAYS = Safe(1.0)
TASK = Driving(tracks="alder,yew", traffic=3, record_every=3, laps=3.0, seconds=2.0)
PLANS = list(plans(TASK, RULES, 2, seed=0))


@pytest.fixture(scope="module")
def driver() -> Driver:
    generator = torch.Generator().manual_seed(0)
    primary = PrimaryNetwork(2, generator=generator)
    return Driver(primary, SafetyNetwork(PrimaryNetwork(2).feature_size, 4, generator=generator))


def traffic_of(plan: Plan) -> int:
    assert isinstance(plan.task, Driving)
    return plan.task.traffic


def plan(strategy: Strategy, traffic: int, rule: Rule | None = None) -> Plan:
    found = next(p for p, _ in PLANS if p.rule.name == strategy and traffic_of(p) == traffic)
    return replace(found, rule=rule or found.rule)


def test_every_case_is_driven_once() -> None:
    cases = {(p.rule.name, traffic_of(p), p.scenario, start) for p, start in PLANS}
    assert len(cases) == len(PLANS) == 3 * 2 * 2 * 2


def test_all_strategies_meet_the_same_starts() -> None:
    naive, safe, optimal = ([p.seed for p, _ in PLANS if p.rule.name == s] for s in DRIVING)
    assert naive == safe == optimal


@pytest.mark.parametrize("strategy", [Strategy.SAFE, Strategy.OPTIMAL])
def test_where_nothing_is_unsafe_it_drives_as_the_naive_strategy(
    strategy: Strategy, driver: Driver
) -> None:
    """A cut of 0; and a tau above every deviation, which turns SafeDAgger into DAgger (Sec. 3.2)."""
    naive, other = (evaluate(plan(s, 3), 0, driver) for s in (Strategy.NAIVE, strategy))
    assert replace(other, strategy=naive.strategy) == naive
    assert naive.takeover_frames == naive.takeovers == naive.switches == 0


def test_where_everything_is_unsafe_the_reference_drives(driver: Driver) -> None:
    outcome = evaluate(plan(Strategy.SAFE, 0, ALWAYS), 0, driver)
    assert outcome.takeover_frames == outcome.frames
    assert (outcome.takeovers, outcome.switches) == (1, 0)
    assert outcome.squared_error_sum == 0
    assert not outcome.off_road


def test_a_drive_ends_after_its_laps(driver: Driver) -> None:
    always = plan(Strategy.SAFE, 0, ALWAYS)
    short = replace(always, task=replace(TASK, traffic=0, laps=0.02))
    outcome = evaluate(short, 0, driver)
    assert outcome.laps == 0.02
    assert outcome.frames < 20


def test_the_optimal_safety_policy_leaves_the_primary_no_deviation_above_tau(
    driver: Driver,
) -> None:
    """Eq. 2: what the primary drives deviates by tau at most; what is left goes to the reference."""
    tau = 1e-4
    rule = Judgement(0.0, tau, measure="steering").rule(Strategy.OPTIMAL)
    outcome = evaluate(plan(Strategy.OPTIMAL, 0, rule), 0, driver)
    assert outcome.squared_error_sum <= tau * outcome.primary_frames
    assert outcome.takeover_frames > 0
    assert outcome.takeovers <= outcome.switches + 1
