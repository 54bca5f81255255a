import subprocess
import sys
import warnings
import zlib

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from pipeline.driving.environment import DrivingEnv
from pipeline.driving.features import CONTROL_HZ, STANDSTILL
from pipeline.driving.reference import reference_actions
from tests.driving.scenes import cars_at, straightest

NAME = "pipeline.driving.environment:safedagger/Driving-v0"
COAST = np.zeros(2, np.float32)

PIXELS = f"""
import zlib, gymnasium, numpy as np
env = gymnasium.make("{NAME}", track="random:7", traffic=20)
seen = zlib.crc32(env.reset(seed=5)[0]["pixels"]["front"])
for steering in np.linspace(-0.1, 0.1, 10, dtype=np.float32):
    seen = zlib.crc32(env.step(np.array([steering, 0.0], np.float32))[0]["pixels"]["front"], seen)
print("pixels", seen)
"""


def test_gymnasiums_own_check_passes_without_a_warning() -> None:
    env = gymnasium.make(NAME, traffic=5, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    assert env.metadata["render_fps"] == CONTROL_HZ


def test_the_same_seed_gives_the_same_pixels_in_any_process(
    capfd: pytest.CaptureFixture[str],
) -> None:
    exec(PIXELS, {})
    here = capfd.readouterr().out
    there = subprocess.run(
        [sys.executable, "-c", PIXELS], capture_output=True, text=True, check=True
    ).stdout
    assert here.split()[-2:] == there.split()[-2:]


def test_seeds_differ() -> None:
    env = DrivingEnv(traffic=5)
    seen = {zlib.crc32(env.reset(seed=seed)[0]["pixels"]["front"]) for seed in range(3)}
    assert len(seen) == 3


def test_what_is_hidden_is_of_the_moment_of_the_observation() -> None:
    env = DrivingEnv(traffic=10, action_repeat=3)
    observation, info = env.reset(seed=0)
    for _ in range(2):
        np.testing.assert_array_equal(observation["pixels"]["front"], env.world.image())
        np.testing.assert_array_equal(info["hidden"]["affordances"], env.world.affordances())
        np.testing.assert_array_equal(info["hidden"]["vehicle_state"], env.world.vehicle_state())
        assert (info["ended"], info["failed"]) == (None, False)
        observation, _, _, _, info = env.step(COAST)
    assert env.outcome()["distance_m"] == pytest.approx(2 * 3 * 20 / CONTROL_HZ, rel=0.2)
    assert env.metadata["render_fps"] == 10


def test_asking_the_reference_changes_nothing() -> None:
    env = DrivingEnv(traffic=10)
    env.reset(seed=0)
    expected = reference_actions(env.world.cars, env.world.track)[0]
    for _ in range(3):
        np.testing.assert_array_equal(env.label(), expected)
        np.testing.assert_array_equal(env.look_up(), expected)
        env.label()[:] = 9.0
    np.testing.assert_array_equal(env.label(), expected)


def test_leaving_the_road_terminates_and_costs_one() -> None:
    env = DrivingEnv()
    env.reset(seed=0)
    rewards, terminated, truncated = [], False, False
    while not terminated:
        _, reward, terminated, truncated, info = env.step(np.array([1.0, 0.0], np.float32))
        rewards.append(reward)
    assert env.outcome()["off_road"] and not truncated
    assert (info["ended"], info["failed"]) == ("road left", True)
    assert rewards[-1] == -1 and sum(rewards) == -1


def test_a_touch_costs_one_and_the_drive_goes_on() -> None:
    env = DrivingEnv(traffic=1)
    env.reset(seed=1)
    track = env.world.track
    s = straightest(track) - 20.0
    env.world.cars = cars_at(track, [s, s + 8.0], [1, 1], limit=[20.0, 5.0])
    steps = [env.step(COAST) for _ in range(CONTROL_HZ)]
    assert env.outcome()["damage"] > 50 and env.outcome()["touches"] == 1
    assert sum(step[1] for step in steps) == -1
    assert not any(step[2] or step[3] for step in steps)


def test_standing_still_truncates() -> None:
    """Both lanes are blocked."""
    env = DrivingEnv(track="willow", traffic=2, action_repeat=3)
    env.reset(seed=0)
    env.world.cars = cars_at(env.world.track, [0.0, 30.0, 30.0], [0, 0, 1], limit=[15.0, 0.0, 0.0])
    frames, over = 0, False
    while not over:
        actions = reference_actions(env.world.cars, env.world.track)
        _, _, terminated, over, info = env.step(actions[0])
        frames += 1
        assert not terminated
    assert (info["ended"], info["failed"]) == ("stood still", True)
    assert env.world.cars.speed[0] == 0 and env.outcome()["damage"] == 0
    assert STANDSTILL <= frames * 3 / CONTROL_HZ < STANDSTILL + 10


@pytest.mark.parametrize(("limit", "frames"), [({"seconds": 0.2}, 6), ({"laps": 0.002}, 2)])
def test_time_and_laps_truncate(limit: dict[str, float], frames: int) -> None:
    env = DrivingEnv(**limit)
    env.reset(seed=0)
    ends = [env.step(COAST)[2:4] for _ in range(frames)]
    assert ends == [(False, False)] * (frames - 1) + [(False, True)]


def test_the_reference_drives_the_traffic() -> None:
    env = DrivingEnv(track="willow", traffic=5)
    env.reset(seed=0)
    for _ in range(CONTROL_HZ):
        env.step(np.array([0.0, 1.0], np.float32))
    assert env.world.cars.speed[0] < 10 and env.world.cars.speed[1:].min() > 3
    assert np.abs(env.world.cars.angle(env.world.track)[1:]).max() < 0.2


def test_bad_arguments_are_refused() -> None:
    bad = {"track": "oak", "laps": -1, "traffic": 1000, "action_repeat": 7}
    for name, value in bad.items():
        with pytest.raises(ValueError, match=rf"{name} .*{value}"):
            DrivingEnv(**{name: value})
    with pytest.raises(gymnasium.error.ResetNeeded):
        DrivingEnv().step(COAST)
