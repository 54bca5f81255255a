from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.cars import DT, LENGTH, WIDTH, Cars
from pipeline.driving.tracks import LANE_WIDTH, Track, make_track
from pipeline.driving.world import World
from tests.driving.scenes import cars_at, overlapping, straightest

WorldOf = Callable[[Track, Cars], World]


def coast(world: World, seconds: float) -> None:
    for _ in range(round(seconds / DT)):
        world.step(np.zeros((len(world.cars), 2)))


def meeting(track: Track, ours: float, theirs: float) -> Cars:
    """Our car behind another, or before it if that is the faster, a metre between the bumpers."""
    s = straightest(track) - 30.0
    ahead = (LENGTH + 1.0) * (1 if ours > theirs else -1)
    return cars_at(track, [s, s + ahead], [1, 1], limit=[ours, theirs])


@pytest.mark.parametrize(
    ("ours", "theirs", "pushing"), [(20, 10, 1), (20, 0, 1), (12, 10, 0), (10, 20, 1)]
)
def test_an_impact_does_damage_by_half_the_squared_closing_speed(
    world_of: WorldOf, alder: Track, ours: float, theirs: float, pushing: float
) -> None:
    """Once, however long [s] the faster car pushes the slower one."""
    world = world_of(alder, meeting(alder, ours, theirs))
    # The governor would change nothing, and in this time the road hardly bends.
    for seconds in (1.2 / abs(ours - theirs), pushing):
        coast(world, seconds)
        assert world.damage == pytest.approx(0.5 * (ours - theirs) ** 2, rel=0.03)


def test_an_impact_shares_the_speed_and_parts_the_cars(world_of: WorldOf, alder: Track) -> None:
    world = world_of(alder, meeting(alder, 20.0, 10.0))
    coast(world, 0.2)
    assert world.cars.speed[0] < world.cars.speed[1]
    np.testing.assert_allclose(world.cars.speed, 15.0, atol=1.0)
    assert not overlapping(world.cars, (LENGTH - 0.2, WIDTH - 0.2))


def test_side_contact_does_damage_once(world_of: WorldOf, alder: Track) -> None:
    angle, speed = 0.2, 15.0
    s = straightest(alder) - 15.0
    cars = cars_at(alder, [s, s], [1, 0], angle=[angle, 0.0], limit=speed)
    world = world_of(alder, cars)
    coast(world, 0.7)
    assert world.damage == pytest.approx(0.5 * (speed * np.sin(angle)) ** 2, rel=0.1)


def test_a_new_touch_counts_anew(world_of: WorldOf, alder: Track) -> None:
    world = world_of(alder, meeting(alder, 20.0, 10.0))
    coast(world, 0.2)
    once = world.damage
    world.cars = meeting(alder, 10.0, 10.0)
    world.cars.s[1] += 10.0
    world.cars.x[1], world.cars.y[1] = alder.centreline.position(world.cars.s[1], world.cars.d[1])
    coast(world, 1.0)
    assert world.damage == once
    assert world.touches == 1
    world.cars = meeting(alder, 20.0, 10.0)
    coast(world, 0.2)
    assert world.damage == pytest.approx(2 * once, rel=0.01)
    assert world.touches == 2


@pytest.mark.parametrize(
    ("ahead", "lanes", "limit"),
    [
        pytest.param([0, 0, -LENGTH - 0.3], [1, 0, 2, 1], 15.0, id="beside, and just behind"),
        pytest.param([70, 80], [1, 0, 0], [15.0, 20.0, 0.0], id="others hit each other"),
    ],
)
def test_no_contact_no_damage(
    world_of: WorldOf, alder: Track, ahead: list[float], lanes: list[int], limit: float
) -> None:
    s = straightest(alder) - (80.0 if ahead[0] else 10.0)
    world = world_of(alder, cars_at(alder, [s, *(s + each for each in ahead)], lanes, limit=limit))
    coast(world, 1.0)
    assert world.damage == 0.0


@given(st.floats(-0.3, 0.3), st.floats(-5.0, 5.0), st.floats(0.0, 3.0))
def test_the_bodies_touch_where_the_rectangles_overlap(
    angle: float, along: float, across: float
) -> None:
    track = make_track("alder")
    s = straightest(track)
    cars = cars_at(track, [s, s + along], [1, 1], angle=[angle, 0.0], offset=[0.0, across])
    grown, shrunk = (bool(overlapping(cars, size=(LENGTH + by, WIDTH + by))) for by in (0.1, -0.1))
    if grown == shrunk:  # else it is too close to call
        with World(track, 1, (0.0, 0.0), np.random.default_rng(0)) as world:
            world.scene.place(cars)
            assert bool(world.scene.contacts()) == grown


def test_laps_are_the_arc_length_driven(world_of: WorldOf, alder: Track) -> None:
    with World(alder, 0, (0.0, 0.0), np.random.default_rng(3)) as world:
        assert world.laps == 0.0
        before = world.cars.s[0]
        coast(world, 1.0)
        assert world.laps == pytest.approx((world.cars.s[0] - before) / alder.length)
        assert world.laps == pytest.approx(20.0 / alder.length, rel=0.05)


def test_the_start_line_is_no_seam(alder: Track) -> None:
    with World(alder, 0, (0.0, 0.0), np.random.default_rng(3)) as world:
        seam = alder.length - world.cars.s[0]
        world.cars = cars_at(alder, [alder.length - 5.0], [1], limit=20.0)
        coast(world, 0.5)
        assert world.laps == pytest.approx((seam + 5.0) / alder.length, rel=0.01)


@pytest.mark.parametrize(
    ("lane", "offset", "angle", "off"),
    [
        (1, 0.0, 0.0, False),
        (0, LANE_WIDTH / 2 + 0.5, 0.0, False),
        (0, LANE_WIDTH / 2 + 0.7, 0.0, True),
        (2, -LANE_WIDTH / 2 - 0.7, 0.0, True),
        (1, 0.0, 1.5, False),
        (1, 0.0, 1.7, True),
        (1, 0.0, -1.7, True),
    ],
)
def test_off_the_road(
    world_of: WorldOf, alder: Track, lane: int, offset: float, angle: float, off: bool
) -> None:
    cars = cars_at(alder, [50.0], [lane], offset=offset, angle=angle)
    assert world_of(alder, cars).off_road is off


@pytest.mark.parametrize("car", [0, 1])
def test_an_action_that_is_no_number_is_refused(world_of: WorldOf, alder: Track, car: int) -> None:
    world = world_of(alder, meeting(alder, 20.0, 10.0))
    actions = np.zeros((2, 2))
    actions[car] = np.nan
    with pytest.raises(ValueError, match=rf"action of car {car} is \[nan nan\], expected finite"):
        world.step(actions)
