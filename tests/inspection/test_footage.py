"""What is shown of a drive, from a dataset and from the drive itself."""

import numpy as np
import pytest

from pipeline.driving.cars import LENGTH
from pipeline.driving.features import SENSOR_RANGE
from pipeline.driving.tracks import LANE_WIDTH, make_track
from pipeline.driving.world import World
from pipeline.inspection.footage import Footage, cars_in_affordances, track_of
from pipeline.rollout.recording import record
from pipeline.rollout.rules.reference import Reference
from tests.drives import plan
from tests.episodes import random_episode

PLAN = plan(
    Reference(), track="random:7", traffic=20, offset_spread=0.3, angle_spread=0.05, seconds=3.0
)


@pytest.mark.parametrize("name", ["alder", "yew", "random:7"])
def test_a_drives_task_names_its_track(name: str) -> None:
    assert track_of(PLAN.task.describe(name)) is make_track(name)


@pytest.mark.parametrize("task", ["coast, 20 cars", "drive on nowhere with 2 other cars"])
def test_another_task_is_refused(task: str) -> None:
    episode = random_episode(np.random.default_rng(0), 1, task=task)
    with pytest.raises(ValueError, match=r"expected"):
        Footage.of_episode(episode)


@pytest.mark.parametrize("name", ["alder", "birch", "yew"])
def test_cars_are_where_the_affordances_say(name: str) -> None:
    """Beside the true ones: at their place along the road, and in a lane that they reach into."""
    track, found = make_track(name), 0
    for seed in range(10):
        with World(track, 40, (0.3, 0.1), np.random.default_rng(seed)) as world:
            state, affordances = world.vehicle_state()[None], world.affordances()[None]
            (cars,) = cars_in_affordances(track, state, affordances)
            assert len(cars) == affordances[0, 2:5].sum()
            s, d = track.centreline.local_coordinates(
                *cars[:, :2].T, world.cars.s[0] + affordances[0, 5:8][affordances[0, 2:5] > 0.5]
            )
            for along, across in zip(s, d, strict=True):
                gap = np.remainder(world.cars.s - along + 300, track.length) - 300
                gap[0] = np.inf
                true = np.argmin(np.hypot(gap, world.cars.d - across))
                ahead = np.remainder(world.cars.s[true] - world.cars.s[0], track.length)
                assert abs(gap[true]) < 0.01 or ahead < LENGTH  # beside us reads as touching
                assert abs(world.cars.d[true] - across) < LANE_WIDTH
                found += 1
            np.testing.assert_allclose(cars[:, 2], track.centreline.heading_at(s), atol=1e-3)
    assert found > 10


def test_a_recorded_drive() -> None:
    episode = record(PLAN, None, 0, 0).episode
    footage = Footage.of_episode(episode, 5)
    np.testing.assert_array_equal(footage.frame, np.arange(5, 35))
    np.testing.assert_array_equal(footage.end[:-1], footage.vehicle_state[1:, :2])
    np.testing.assert_array_equal(footage.end[-1], footage.vehicle_state[-1, :2])
    np.testing.assert_array_equal(footage.reference_action, episode.columns["action"])
    near = (episode.columns["affordances"][:, 5:8] < SENSOR_RANGE).sum(axis=1)
    assert [len(cars) for cars in footage.others] == near.tolist()
    part = footage.rows(3, 9)
    assert len(part) == 6
    np.testing.assert_array_equal(part.vehicle_state, footage.vehicle_state[3:9])
