from copy import deepcopy
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.cars import DT, LENGTH, Cars, move, place
from pipeline.driving.reference import BRAKE_TIME, CHANGE_GAP, reference_actions
from pipeline.driving.tracks import LANE_WIDTH, Track, make_track
from pipeline.driving.traffic import SPEED_LIMIT, start
from pipeline.driving.world import World
from tests.driving.scenes import NAMES, cars_at, overlapping, straightest, track_names

seeds = st.integers(0, 2**32 - 1)
two_lane_names = st.sampled_from([name for name in NAMES if make_track(name).lanes == 2])


def drive(cars: Cars, track: Track, seconds: float) -> None:
    """The reference drives every car."""
    for _ in range(round(seconds / DT)):
        move(cars, reference_actions(cars, track), track)


@given(track_names, seeds, st.integers(0, 40))
def test_it_is_a_pure_function_of_the_state(name: str, seed: int, traffic: int) -> None:
    track = make_track(name)
    cars = start(track, traffic, (0.5, 0.1), np.random.default_rng(seed))
    before = deepcopy(cars)
    first = reference_actions(cars, track)
    move(deepcopy(cars), first, track)
    again = reference_actions(cars, track)
    np.testing.assert_array_equal(first, again)
    for field in fields(cars):
        np.testing.assert_array_equal(getattr(cars, field.name), getattr(before, field.name))


@given(track_names, seeds, st.floats(0, 5), st.floats(0, 1))
def test_actions_are_within_their_ranges(name: str, seed: int, offset: float, angle: float) -> None:
    track = make_track(name)
    cars = start(track, 40, (offset, angle), np.random.default_rng(seed))
    actions = reference_actions(cars, track)
    assert actions.shape == (41, 2) and actions.dtype == np.float32
    assert np.all(np.abs(actions[:, 0]) <= 1) and set(actions[:, 1]) <= {0.0, 1.0}


@pytest.mark.parametrize("name", NAMES)
def test_it_keeps_its_lane_at_the_speed_limit(name: str) -> None:
    track = make_track(name)
    for lane in range(track.lanes):
        cars = cars_at(track, [0.0], [lane], limit=SPEED_LIMIT)
        for _ in range(round(track.length / SPEED_LIMIT / DT)):
            actions = reference_actions(cars, track)
            assert actions[0, 1] == 0
            move(cars, actions, track)
            assert abs(cars.d[0] - track.lane_centres[lane]) < 0.25 * LANE_WIDTH
        assert cars.speed[0] == pytest.approx(SPEED_LIMIT)


@pytest.mark.parametrize("offset", [-1.5, 1.5])
@pytest.mark.parametrize("angle", [-0.15, 0.0, 0.15])
def test_it_returns_from_an_offset(alder: Track, offset: float, angle: float) -> None:
    s = straightest(alder) - 60.0
    cars = cars_at(alder, [s], [1], offset=offset, angle=angle, limit=SPEED_LIMIT)
    drive(cars, alder, 4.0)
    assert abs(cars.d[0] - alder.lane_centres[alder.lane_of(cars.d)[0]]) < 0.4
    assert abs(cars.angle(alder)[0]) < 0.1


def test_it_brakes_for_a_close_car_that_it_cannot_pass(willow: Track) -> None:
    s = straightest(willow)
    gap = BRAKE_TIME * SPEED_LIMIT
    for beyond, brakes in ((-1.0, 1), (1.0, 0)):
        ahead = s + LENGTH + gap + beyond
        cars = cars_at(willow, [s, ahead, s], [0, 0, 1], limit=SPEED_LIMIT)
        assert reference_actions(cars, willow)[0, 1] == brakes


def test_it_stops_behind_a_standing_car(willow: Track) -> None:
    s = straightest(willow)
    blocked = [s, s + 60.0, s + 60.0]
    cars = cars_at(willow, blocked, [0, 0, 1], limit=[SPEED_LIMIT, 0.0, 0.0])
    drive(cars, willow, 10.0)
    assert cars.speed[0] < 0.1
    assert 0.5 < cars.s[1] - cars.s[0] - LENGTH < BRAKE_TIME * SPEED_LIMIT


def test_it_stops_behind_a_standing_queue_when_asked_at_ten_hertz(willow: Track) -> None:
    """A recorded frame stands for up to three control steps, and its action is held for them."""
    for ahead in np.arange(60.0, 70.0, 0.5):
        cars = cars_at(willow, [0.0, ahead, ahead], [0, 0, 1], limit=[SPEED_LIMIT, 0.0, 0.0])
        for _ in range(40):
            held = reference_actions(cars, willow)
            for _ in range(3):
                move(cars, held, willow)
        assert cars.s[1] - cars.s[0] > LENGTH


def test_it_does_not_brake_for_a_car_that_it_passes_in_the_next_lane(willow: Track) -> None:
    s = straightest(willow)
    for ahead in (0.0, 3.0, 10.0, 20.0):
        cars = cars_at(willow, [s, s + ahead], [0, 1], limit=SPEED_LIMIT)
        assert reference_actions(cars, willow)[0, 1] == 0


def pull(track: Track, s: list[float], lane: list[int]) -> float:
    """How far the other cars make ours steer to the left of where it would go alone."""
    alone = reference_actions(cars_at(track, s[:1], lane[:1]), track)[0, 0]
    return float(reference_actions(cars_at(track, s, lane), track)[0, 0] - alone)


@pytest.mark.parametrize(
    ("others", "lanes", "sign"),
    [
        pytest.param([32], [0], -1, id="to the right, which is free"),
        pytest.param([32], [2], 1, id="to the left, which is free"),
        pytest.param([], [], 1, id="to the left where both are free"),
        pytest.param([32, 32], [0, 2], 0, id="nowhere: no lane is freer"),
        *(
            pytest.param([beside, beside], [0, 2], 0, id=f"nowhere: cars at {beside} m")
            for beside in (-8, -2, 0, 2, 4)
        ),
    ],
)
def test_behind_another_it_changes(
    alder: Track, others: list[float], lanes: list[int], sign: int
) -> None:
    s = straightest(alder)
    left = pull(alder, [s, s + 28.0, *(s + ahead for ahead in others)], [1, 1, *lanes])
    assert sign * left > 0.05 if sign else left == 0


def test_it_waits_for_a_faster_car_from_behind(willow: Track) -> None:
    s = straightest(willow)
    for behind, sign in ((20.0, 0), (45.0, 1)):
        cars = cars_at(willow, [s, s + 25.0, s - behind], [1, 1, 0], limit=[8.0, 8.0, 20.0])
        alone = cars_at(willow, [s], [1], limit=8.0)
        left = reference_actions(cars, willow)[0, 0] - reference_actions(alone, willow)[0, 0]
        assert np.sign(np.round(left, 6)) == sign


def test_the_pull_grows_without_a_jump_as_the_car_ahead_comes_nearer(willow: Track) -> None:
    s = straightest(willow)
    gaps = np.linspace(CHANGE_GAP + 5.0, 22.0, 250)
    pulls = np.array([pull(willow, [s, s + LENGTH + gap], [1, 1]) for gap in gaps])
    assert pulls[0] == 0 and pulls[-1] > 0.05
    assert np.all(np.diff(pulls) >= -1e-6) and np.diff(pulls).max() < 0.01


def test_it_overtakes_a_slower_car(willow: Track) -> None:
    cars = cars_at(willow, [0.0, 60.0], [1, 1], limit=[SPEED_LIMIT, 10.0])
    for _ in range(round(15 / DT)):
        drive(cars, willow, DT)
        assert not overlapping(cars)
    assert cars.s[0] > cars.s[1] + 20.0
    assert np.abs(cars.d - willow.lane_centres[willow.lane_of(cars.d)]).max() < 0.9


def mirrored(track: Track) -> Track:
    """The same road seen in a mirror: left bends become right bends."""
    line = track.centreline
    flipped = replace(line, y=-line.y, heading=-line.heading, curvature=-line.curvature)
    return replace(track, centreline=flipped)


@given(two_lane_names, seeds, st.integers(0, 40))
def test_left_and_right_are_treated_alike(name: str, seed: int, traffic: int) -> None:
    """On two lanes, where there is never a choice between both sides, which the left side wins."""
    track = make_track(name)
    cars = start(track, traffic, (0.5, 0.1), np.random.default_rng(seed))
    mirror = mirrored(track)
    image = place(mirror, cars.s, -cars.d, -cars.angle(track), cars.limit)
    seen, other = reference_actions(cars, track), reference_actions(image, mirror)
    np.testing.assert_allclose(seen * [-1, 1], other, atol=1e-5)


@pytest.mark.parametrize(("name", "seed"), [("willow", 0), ("alder", 1), ("maple", 2)])
def test_a_lap_in_dense_traffic_without_damage(name: str, seed: int) -> None:
    """`test_reference_long.py` drives three laps on thirty tracks."""
    with World(make_track(name), 40, (0.3, 0.05), np.random.default_rng(seed)) as world:
        for _ in range(round(120 / DT)):
            if world.laps >= 1:
                break
            world.step(reference_actions(world.cars, world.track))
            assert not world.off_road and world.damage == 0
        assert world.laps >= 1
