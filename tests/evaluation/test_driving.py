from dataclasses import replace

import pytest

from pipeline.driving.task import Driving
from pipeline.evaluation.drives import COLUMNS
from pipeline.evaluation.driving import Trial, evaluate, trials
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement, rule_of
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import DRIVING, Strategy
from tests.drives import untrained

TRUSTING = Judgement(cut=0.0, tau=9.0, measure="steering")
RULES = [rule_of(strategy, TRUSTING) for strategy in DRIVING]
ALWAYS = Safe(1.0)
TASK = Driving(tracks="alder,yew", traffic=3, action_repeat=3, laps=3.0, seconds=2.0)
TRIALS = list(trials(TASK, list(TASK.conditions), RULES, 2, seed=0))


@pytest.fixture(scope="module")
def driver() -> Driver:
    return untrained()


def trial(strategy: Strategy, condition: str, rule: Rule | None = None) -> Trial:
    found = next(t for t in TRIALS if (t.plan.rule.name, t.condition) == (strategy, condition))
    return replace(found, plan=replace(found.plan, rule=rule or found.plan.rule))


def test_every_case_is_driven_once_and_all_strategies_meet_the_same_starts() -> None:
    cases = {(t.plan.rule.name, t.condition, t.plan.scenario, t.start) for t in TRIALS}
    assert len(cases) == len(TRIALS) == 3 * 2 * 2 * 2
    conditions = {(t.condition, *t.settings.items()) for t in TRIALS}
    assert conditions == {("no_traffic", ("traffic", 0)), ("traffic", ("traffic", 3))}
    naive, safe, optimal = ([t.plan.seed for t in TRIALS if t.plan.rule.name == s] for s in DRIVING)
    assert naive == safe == optimal


def test_one_condition_alone_is_driven_as_among_all() -> None:
    alone = list(trials(TASK, ["traffic"], RULES, 2, seed=0))
    assert alone == [each for each in TRIALS if each.condition == "traffic"]


@pytest.mark.parametrize("strategy", [Strategy.SAFE, Strategy.OPTIMAL])
def test_where_nothing_is_unsafe_it_drives_as_the_naive_strategy(
    strategy: Strategy, driver: Driver
) -> None:
    """A cut of 0; and a tau above every deviation, which turns SafeDAgger into DAgger (Sec. 3.2)."""
    naive, other = (evaluate(trial(s, "traffic"), driver) for s in (Strategy.NAIVE, strategy))
    assert other | {"strategy": naive["strategy"]} == naive
    assert naive["takeover_frames"] == naive["takeovers"] == naive["switches"] == 0


def test_where_everything_is_unsafe_the_reference_drives(driver: Driver) -> None:
    row = evaluate(trial(Strategy.SAFE, "no_traffic", ALWAYS), driver)
    assert row["takeover_frames"] == row["frames"]
    assert (row["takeovers"], row["switches"]) == (1, 0)
    assert row["deviation_sum"] == 0
    assert (row["off_road"], row["ended"]) == (0.0, "out of time")


def test_a_drive_ends_after_its_laps(driver: Driver) -> None:
    always = trial(Strategy.SAFE, "no_traffic", ALWAYS)
    short = replace(TASK, traffic=0, laps=0.02)
    row = evaluate(replace(always, plan=replace(always.plan, task=short)), driver)
    assert (row["laps"], row["ended"]) == (0.02, "laps done")
    assert row["frames"] < 20


def test_the_optimal_safety_policy_leaves_the_primary_no_deviation_above_tau(
    driver: Driver,
) -> None:
    """Eq. 2: what the primary drives deviates by tau at most; what is left goes to the reference."""
    tau = 1e-4
    rule = rule_of(Strategy.OPTIMAL, Judgement(0.0, tau, measure="steering"))
    row = evaluate(trial(Strategy.OPTIMAL, "no_traffic", rule), driver)
    assert row["deviation_sum"] <= tau * row["primary_frames"]
    assert row["takeover_frames"] > 0
    assert row["takeovers"] <= row["switches"] + 1


def test_a_row_has_all_columns_but_who_drove(driver: Driver) -> None:
    row = evaluate(trial(Strategy.NAIVE, "traffic"), driver)
    assert set(COLUMNS) - row.keys() == {"primary", "begun_with", "processor"}
    assert row.keys() - set(COLUMNS) == {
        "traffic", "laps", "distance_m", "damage", "touches", "off_road"
    }  # fmt: skip
