from collections.abc import Callable, Iterator

import numpy as np
import pytest

from pipeline.driving.cars import Cars
from pipeline.driving.tracks import Track, make_track
from pipeline.driving.world import World


@pytest.fixture
def alder() -> Track:
    """Three lanes, grass beside them."""
    return make_track("alder")


@pytest.fixture
def willow() -> Track:
    """Two lanes."""
    return make_track("willow")


@pytest.fixture
def world_of() -> Iterator[Callable[[Track, Cars], World]]:
    """Makes worlds with the cars where they are wanted, and closes them."""
    worlds: list[World] = []

    def make(track: Track, cars: Cars) -> World:
        world = World(track, len(cars) - 1, (0.0, 0.0), np.random.default_rng(0))
        worlds.append(world)
        world.cars = cars
        world.scene.place(cars)
        return world

    yield make
    for world in worlds:
        world.close()
