from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.driving import camera
from pipeline.driving.cars import Cars
from pipeline.driving.features import IMAGE_SHAPE
from pipeline.driving.tracks import SHOULDER, Track, make_track
from pipeline.driving.world import World
from tests.driving.scenes import NAMES, cars_at, straightest

WorldOf = Callable[[Track, Cars], World]
HORIZON = 24  # first row that may show road; the sky lies above


def test_our_own_car_is_not_visible(world_of: WorldOf, alder: Track) -> None:
    cars = cars_at(alder, [100.0], [1])
    world = world_of(alder, cars)
    with_it = world.image()
    world.scene.place(replace(cars, x=cars.x + 500.0))
    without = camera.render(world.scene, cars.x[0], cars.y[0], cars.heading[0])
    np.testing.assert_array_equal(with_it, without)


@pytest.mark.parametrize("lane", [0, 1, 2])
@pytest.mark.parametrize("gap", [8.0, 30.0, 55.0])
def test_a_car_in_front_can_be_seen_where_it_is(
    world_of: WorldOf, alder: Track, lane: int, gap: float
) -> None:
    s = straightest(alder) - 20.0
    alone = world_of(alder, cars_at(alder, [s, s - 60.0], [1, 1])).image()
    followed = world_of(alder, cars_at(alder, [s, s + 4.4 + gap], [1, lane])).image()
    rows, columns = np.nonzero(np.any(alone != followed, axis=2))
    assert len(rows) >= 4
    assert rows.min() > HORIZON - 12
    if gap == 8.0:
        middle = columns.mean() - IMAGE_SHAPE[1] / 2
        assert np.sign(np.round(middle / 20)) == lane - 1


@pytest.mark.parametrize("name", NAMES)
def test_the_sky_is_above_the_road_which_is_whole_up_to_our_bonnet(
    world_of: WorldOf, name: str
) -> None:
    track = make_track(name)
    world = world_of(track, cars_at(track, [0.0], [0]))
    paints = np.array([track.look.line, track.look.edge, [track.look.asphalt] * 3])
    for s in np.linspace(0, track.length, 40):
        world.cars = cars_at(track, [s], [track.lanes // 2])
        world.cars.x[0], world.cars.y[0] = track.centreline.position(s, 0.0)
        world.scene.place(world.cars)
        image = world.image().astype(int)
        assert not np.any(np.all(image == 255, axis=2)), "nothing was drawn there"
        assert np.median(np.abs(image[0] - track.look.sky).max(axis=1)) <= 4
        nearest = image[-4:, 40:120]
        away = np.abs(nearest[:, :, None] - paints).max(axis=3).min(axis=2)
        assert np.mean(away) < 40, "sky or ground where asphalt should be"


def test_the_edge_line_is_where_a_pinhole_camera_sees_it(world_of: WorldOf, alder: Track) -> None:
    s = straightest(alder) - 20.0
    cars = cars_at(alder, [s], [1])
    image = world_of(alder, cars).image().min(axis=2)
    forward = np.array([np.cos(cars.heading[0]), np.sin(cars.heading[0])])
    focal = IMAGE_SHAPE[0] / 2 / np.tan(np.radians(camera.FIELD_OF_VIEW / 2))
    for ahead in np.arange(10.0, 32.0, 2.0):  # beyond, it fades
        for side in (1, -1):
            d = side * (alder.half_width - SHOULDER)
            x, y = alder.centreline.position(np.array([s + ahead]), np.array([d]))
            away = np.array([x[0] - cars.x[0], y[0] - cars.y[0]])
            depth = away @ forward + camera.BACK
            left = forward[0] * away[1] - forward[1] * away[0]
            column = IMAGE_SHAPE[1] / 2 - focal * left / depth
            row = IMAGE_SHAPE[0] / 2 + focal * np.tan(np.arctan(camera.UP / depth) - camera.PITCH)
            near = image[int(row) - 2 : int(row) + 3, int(column) - 2 : int(column) + 3]
            assert near.max() > alder.look.asphalt + 25, (ahead, side)


def test_steering_left_moves_the_world_right(world_of: WorldOf, alder: Track) -> None:
    """The camera turns with the car: what was ahead is seen to the right of the middle."""
    s = straightest(alder) - 20.0
    away, near = [s, s - 60.0], [s, s + 20.0]
    empty, car = (
        world_of(alder, cars_at(alder, place, [1, 1], angle=[0.2, 0.0])).image()
        for place in (away, near)
    )
    columns = np.nonzero(np.any(empty != car, axis=(0, 2)))[0]
    assert columns.mean() > IMAGE_SHAPE[1] / 2 + 10
