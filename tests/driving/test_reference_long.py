"""The whole promise about the reference, in about five minutes: `pytest -m slow` runs it.

It is left out of the suite (see `addopts` in pyproject.toml), where test_reference.py drives a lap
on three tracks. Run it after every change to the world or to the reference: nothing that is
learned can be better than its teacher.
"""

import numpy as np
import pytest

from pipeline.driving.cars import DT, move
from pipeline.driving.reference import reference_actions
from pipeline.driving.tracks import make_track
from pipeline.driving.traffic import start
from pipeline.driving.world import World
from tests.driving.scenes import NAMES, overlapping

pytestmark = pytest.mark.slow

TRACKS = [*NAMES, *(f"random:{seed}" for seed in range(20))]


@pytest.mark.parametrize("name", TRACKS)
def test_three_laps_among_forty_cars_without_damage_or_leaving_the_road(name: str) -> None:
    """No other car hits one either, or leaves the road: they have the same driver."""
    track = make_track(name)
    with World(track, 40, (0.3, 0.05), np.random.default_rng(0)) as world:
        for _ in range(round(600 / DT)):
            if world.laps >= 3:
                break
            world.step(reference_actions(world.cars, track))
            assert not world.off_road and world.damage == 0
            assert np.all(np.abs(world.cars.d) < track.half_width)
            assert not overlapping(world.cars)
        assert world.laps >= 3


@pytest.mark.parametrize("name", ["birch", "willow", "random:19"])
def test_no_jam_lasts_for_ever(name: str) -> None:
    """Ten minutes on two lanes: waves come and go, and in every minute every car gets on."""
    track = make_track(name)
    cars = start(track, 40, (0.3, 0.05), np.random.default_rng(0))
    for minute in range(1, 11):
        speeds = []
        for _ in range(round(60 / DT)):
            move(cars, reference_actions(cars, track), track)
            speeds.append(cars.speed.copy())
        frames = np.array(speeds)
        shares = np.percentile(frames, [5, 25, 50, 75, 95]).round(1)
        print(f"{name} minute {minute}: 5, 25, 50, 75, 95 % of speeds {shares} m/s")
        assert frames.mean(axis=0).min() > 2.0
        assert np.median(frames) > 8.0
