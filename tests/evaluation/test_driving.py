from dataclasses import replace

import pytest
import torch

from pipeline.evaluation.driving import evaluate, plans
from pipeline.policies.inference import Driver
from pipeline.policies.network import PrimaryNetwork, SafetyNetwork, feature_size
from pipeline.policies.recording import Drive
from pipeline.policies.strategies import Strategy

PLANS = list(plans(["alder", "yew"], 3, 2, cut=0.0, record_every=3, laps=3.0, seconds=2.0, seed=0))


@pytest.fixture(scope="module")
def driver() -> Driver:
    generator = torch.Generator().manual_seed(0)
    primary = PrimaryNetwork(2, generator=generator)
    return Driver(primary, SafetyNetwork(feature_size(2), 4, generator=generator), brake_cut=0.5)


def plan(strategy: Strategy, traffic: int) -> Drive:
    return next(p for p, _ in PLANS if p.strategy is strategy and p.traffic == traffic)


def test_every_case_is_driven_once() -> None:
    cases = {(p.strategy, p.traffic, p.track, start) for p, start in PLANS}
    assert len(cases) == len(PLANS) == 2 * 2 * 2 * 2


def test_both_strategies_meet_the_same_starts() -> None:
    naive, safe = (
        [p.seed for p, _ in PLANS if p.strategy is s] for s in (Strategy.NAIVE, Strategy.SAFE)
    )
    assert naive == safe


def test_where_nothing_is_unsafe_the_safe_strategy_drives_as_the_naive_one(driver: Driver) -> None:
    naive, safe = (evaluate(plan(s, 3), 0, driver) for s in (Strategy.NAIVE, Strategy.SAFE))
    assert replace(safe, strategy=naive.strategy) == naive
    assert naive.takeover_frames == 0


def test_where_everything_is_unsafe_the_reference_drives(driver: Driver) -> None:
    outcome = evaluate(replace(plan(Strategy.SAFE, 0), cut=1.0), 0, driver)
    assert outcome.takeover_frames == outcome.frames
    assert outcome.squared_error_sum == 0
    assert not outcome.off_road


def test_a_drive_ends_after_its_laps(driver: Driver) -> None:
    short = replace(plan(Strategy.SAFE, 0), cut=1.0, laps=0.02)
    outcome = evaluate(short, 0, driver)
    assert outcome.laps == 0.02
    assert outcome.frames < 20
