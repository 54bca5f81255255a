"""The closed loop with the reference at the wheel; test_inference.py has the networks."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch

from pipeline.driving.features import CONTROL_HZ, IMAGE_SHAPE
from pipeline.driving.reference import reference_actions
from pipeline.driving.tracks import make_track
from pipeline.driving.world import World
from pipeline.policies.inference import Driver
from pipeline.policies.network import PrimaryNetwork
from pipeline.rollout.loop import STANDSTILL, Ended, Frame, drive
from pipeline.rollout.strategies import Rule, Strategy
from tests.driving.scenes import cars_at


@pytest.fixture
def world() -> Iterator[World]:
    with World(make_track("willow"), 10, (0.3, 0.05), np.random.default_rng(0)) as world:
        yield world


def by_reference(
    world: World, *, record_every: int = 3, laps: float = 3.0, seconds: float = 2.0
) -> Iterator[Frame]:
    return drive(
        world,
        None,
        Rule(Strategy.REFERENCE),
        record_every=record_every,
        laps=laps,
        seconds=seconds,
        rng=np.random.default_rng(0),
    )


def test_a_frame_is_what_was_seen_and_known_before_it_was_driven(world: World) -> None:
    image, known = world.image(), world.affordances()
    cars = world.cars
    state = [cars.x[0], cars.y[0], cars.heading[0], cars.speed[0]]
    action = reference_actions(world.cars, world.track)[0]
    frame = next(by_reference(world))
    np.testing.assert_array_equal(frame.vehicle_state, np.float32(state))
    np.testing.assert_array_equal(frame.image, image)
    np.testing.assert_array_equal(frame.affordances, known)
    np.testing.assert_array_equal(frame.reference_action, action)
    assert frame.image.shape == IMAGE_SHAPE


def test_without_a_primary_there_is_no_action_of_its_and_no_error(world: World) -> None:
    frame = next(by_reference(world))
    assert np.all(np.isnan(frame.primary_action)) and np.isnan(frame.safe_probability)
    assert np.isnan(frame.squared_error)
    assert frame.intervention is True


@pytest.mark.parametrize("record_every", [1, 3])
def test_it_drives_as_long_as_it_may(world: World, record_every: int) -> None:
    start = world.cars.s[0]
    frames = list(by_reference(world, record_every=record_every, seconds=2.0))
    assert len(frames) == 2 * CONTROL_HZ / record_every
    assert world.cars.s[0] - start > 10
    assert all(frame.intervention for frame in frames)
    assert [frame.ended for frame in frames] == [None] * (len(frames) - 1) + [Ended.OUT_OF_TIME]


def test_an_action_is_held_for_the_whole_frame(world: World) -> None:
    """As a world stepped by hand shows."""
    first = next(by_reference(world, record_every=3))
    with World(world.track, 10, (0.3, 0.05), np.random.default_rng(0)) as other:
        for _ in range(3):
            actions = reference_actions(other.cars, other.track)
            actions[0] = first.reference_action
            other.step(actions)
        for name in ("x", "y", "heading", "speed"):
            np.testing.assert_array_equal(getattr(world.cars, name), getattr(other.cars, name))


def test_it_ends_with_the_laps(world: World) -> None:
    frames = list(by_reference(world, laps=0.1, seconds=60.0))
    assert 0.1 <= world.laps < 0.1 + 3 * 20 / CONTROL_HZ / world.track.length
    assert len(frames) < 60 * CONTROL_HZ / 3
    assert frames[-1].ended is Ended.LAPS_DONE and not frames[-1].ended.failed
    assert frames[-1].distance == world.distance == pytest.approx(world.laps * world.track.length)


def test_it_ends_off_the_road() -> None:
    track = make_track("willow")
    with World(track, 0, (0.0, 0.0), np.random.default_rng(0)) as world:
        world.cars = cars_at(track, [0.0], [0], offset=5.0)
        (frame,) = by_reference(world)
        assert world.off_road
        assert frame.ended is Ended.ROAD_LEFT and frame.ended.failed


def test_it_ends_where_the_car_stands_still() -> None:
    """Both lanes are blocked."""
    track = make_track("willow")
    with World(track, 2, (0.0, 0.0), np.random.default_rng(0)) as world:
        world.cars = cars_at(track, [0.0, 30.0, 30.0], [0, 0, 1], limit=[15.0, 0.0, 0.0])
        frames = list(by_reference(world, seconds=STANDSTILL + 60.0))
        assert world.cars.speed[0] == 0 and world.damage == 0
        assert STANDSTILL <= len(frames) * 3 / CONTROL_HZ < STANDSTILL + 10
        assert frames[-1].ended is Ended.STOOD_STILL and frames[-1].ended.failed


def test_an_action_that_is_no_number_is_refused_at_once(world: World) -> None:
    primary = PrimaryNetwork(2, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        primary.outputs["steering"][2].weight.fill_(np.nan)
    frames = drive(
        world,
        Driver(primary, brake_cut=0.5),
        Rule(Strategy.NAIVE),
        record_every=3,
        laps=1.0,
        seconds=2.0,
        rng=np.random.default_rng(0),
    )
    with pytest.raises(ValueError, match=r"the primary's action is \[nan +0\.\], expected finite"):
        next(frames)


def test_equal_worlds_are_driven_equally() -> None:
    """Bit for bit, pixels and all."""
    runs = []
    for _ in range(2):
        with World(make_track("yew"), 20, (0.3, 0.05), np.random.default_rng(4)) as world:
            runs.append(list(by_reference(world, seconds=1.0)))
    for one, other in zip(*runs, strict=True):
        np.testing.assert_array_equal(one.image, other.image)
        np.testing.assert_array_equal(one.reference_action, other.reference_action)
