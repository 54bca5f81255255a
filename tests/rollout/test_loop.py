"""The closed loop with the reference at the wheel; test_inference.py has the networks."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

from pipeline.data.schema import Asked
from pipeline.driving.environment import DrivingEnv
from pipeline.driving.features import CAMERA, CONTROL_HZ
from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.reference import reference_actions
from pipeline.driving.tracks import make_track
from pipeline.driving.world import World
from pipeline.environment import Action, Environment
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement, rule_of
from pipeline.rollout.loop import Frame, drive
from pipeline.rollout.plans import driven, one_number
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import Strategy
from tests.drives import plan, untrained

WILLOW = {
    "track": "willow",
    "traffic": 10,
    "offset_spread": 0.3,
    "angle_spread": 0.05,
    "seed": (0,),
}


def by_reference(**settings: Any) -> Iterator[tuple[Environment, Frame]]:
    return driven(plan(Reference(), **(WILLOW | {"seconds": 2.0} | settings)), None)


def test_a_frame_is_what_was_seen_and_known_before_it_was_driven() -> None:
    rng = np.random.default_rng((0,))
    with World(make_track("willow"), 10, (0.3, 0.05), rng) as world:
        image, known, state = world.image(), world.affordances(), world.vehicle_state()
        action = reference_actions(world.cars, world.track)[0]
    _, frame = next(by_reference())
    np.testing.assert_array_equal(frame.observation[CAMERA], image)
    np.testing.assert_array_equal(frame.hidden["affordances"], known)
    np.testing.assert_array_equal(frame.hidden["vehicle_state"], state)
    np.testing.assert_array_equal(frame.reference_action, action)


def test_without_a_primary_there_is_no_action_of_its_and_no_error() -> None:
    _, frame = next(by_reference())
    assert np.all(np.isnan(frame.primary_action)) and np.isnan(frame.safe_probability)
    assert frame.intervention is True


@pytest.mark.parametrize("action_repeat", [1, 3])
def test_it_drives_as_long_as_it_may(action_repeat: int) -> None:
    frames = [frame for _, frame in by_reference(action_repeat=action_repeat)]
    assert len(frames) == 2 * CONTROL_HZ / action_repeat
    assert frames[-1].outcome["distance_m"] > 10
    assert all(frame.intervention for frame in frames)
    assert [frame.ended for frame in frames] == [None] * (len(frames) - 1) + ["out of time"]
    assert not frames[-1].failed


def test_an_action_is_held_for_the_whole_frame() -> None:
    """As a world stepped by hand shows."""
    env, first = next(drives := by_reference())
    rng = np.random.default_rng((0,))
    with World(make_track("willow"), 10, (0.3, 0.05), rng) as other:
        for _ in range(3):
            actions = reference_actions(other.cars, other.track)
            actions[0] = first.reference_action
            other.step(actions)
        for name in ("x", "y", "heading", "speed"):
            np.testing.assert_array_equal(getattr(env.world.cars, name), getattr(other.cars, name))
    drives.close()


def test_an_action_that_is_no_number_is_refused_at_once() -> None:
    driver = untrained()
    driver.primary.outputs["steering"][2].weight.fill_(np.nan)
    frames = driven(plan(Naive(), **WILLOW), driver)
    with pytest.raises(ValueError, match=r"the primary's action is \[nan +0\.\], expected finite"):
        next(frames)


@pytest.mark.parametrize("seed", [(0,), (0, 0, 0), (3, 1002, 0), (0, 101, 2**32 - 1), (7, 1, 2, 3)])
def test_a_seed_of_several_numbers_draws_the_same_as_one(seed: tuple[int, ...]) -> None:
    one = np.random.Generator(np.random.PCG64(np.random.SeedSequence(one_number(seed))))
    assert one.random(9).tolist() == np.random.default_rng(seed).random(9).tolist()


class CountingEnv(DrivingEnv):
    """Counts by itself how often its reference is asked."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.labels = self.look_ups = 0

    def label(self) -> Action:
        self.labels += 1
        return super().label()

    def look_up(self) -> Action:
        self.look_ups += 1
        return super().look_up()


JUDGED = Judgement(0.5, 0.0, "steering-and-brake")


@pytest.mark.parametrize("measure", [False, True])
@pytest.mark.parametrize(
    "rule",
    [Reference(), Naive(), Safe(0.5), Safe(0.0), Mixture(0.5), rule_of(Strategy.OPTIMAL, JUDGED)],
    ids=lambda rule: rule.name,
)
def test_the_reference_is_asked_as_often_as_the_ledger_will_count(
    rule: Rule, measure: bool
) -> None:
    """The heart of the product: a query is a call of `label`, and nothing else is."""
    env = CountingEnv(track="alder", traffic=3, action_repeat=3, seconds=2.0)
    told: dict[str, Any] = {"can_look_up": True, "measure": measure}
    frames = list(drive(env, untrained(), rule, seed=1, rng=np.random.default_rng(1), **told))
    env.close()
    asked = sum(frame.decision.asked is not Asked.NOT for frame in frames)
    assert env.labels == asked
    assert sum(frame.intervention for frame in frames) <= asked
    looked_up = len(frames) if rule.looks_up else (len(frames) - asked if measure else 0)
    assert env.look_ups == looked_up
    known = sum(bool(np.isfinite(frame.reference_action).all()) for frame in frames)
    assert known == (len(frames) if measure or rule.looks_up else asked)


class Counting(Driver):
    """Its action is how often it has acted since it was reset."""

    def reset(self) -> None:
        self.acted = 0

    def act(self, seen: Mapping[str, np.ndarray]) -> tuple[np.ndarray, dict[str, float]]:
        self.acted += 1
        return np.full(2, self.acted, np.float32), {}


def test_the_policy_is_reset_before_a_drive_and_after_each_frame_of_the_references() -> None:
    """What it had planned was for a robot that nobody else has moved."""
    policy = Counting(PrimaryNetwork(2))
    for _ in range(2):
        frames = [frame for _, frame in driven(plan(Mixture(0.4), seconds=2.0, seed=(0,)), policy)]
        assert len({frame.intervention for frame in frames}) == 2
        expected = 1
        for frame in frames:
            assert frame.primary_action.tolist() == [expected, expected]
            expected = 1 if frame.intervention else expected + 1


def test_a_reference_that_cannot_be_looked_up_is_not() -> None:
    """A person, say: what nobody asked, nobody knows."""
    env = CountingEnv(track="alder", action_repeat=3, seconds=1.0)
    told: dict[str, Any] = {"can_look_up": False, "measure": True}
    frames = list(drive(env, untrained(), Naive(), seed=0, rng=np.random.default_rng(0), **told))
    env.close()
    assert (env.labels, env.look_ups) == (0, 0)
    assert all(np.isnan(frame.reference_action).all() for frame in frames)
