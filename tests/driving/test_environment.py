import subprocess
import sys
import warnings
import zlib

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from pipeline.driving.environment import DrivingEnv
from pipeline.driving.features import AFFORDANCES, CONTROL_HZ
from pipeline.driving.reference import reference_actions
from tests.driving.scenes import cars_at, straightest

NAME = "pipeline.driving.environment:safedagger/Driving-v0"
COAST = np.zeros(2, np.float32)

PIXELS = f"""
import zlib, gymnasium, numpy as np
env = gymnasium.make("{NAME}", track="random:7", traffic=20)
seen = zlib.crc32(env.reset(seed=5)[0])
for steering in np.linspace(-0.1, 0.1, 10, dtype=np.float32):
    seen = zlib.crc32(env.step(np.array([steering, 0.0], np.float32))[0], seen)
print("pixels", seen)
"""


def env_with(**settings: object) -> DrivingEnv:
    return DrivingEnv(traffic_driver=reference_actions, **settings)  # type: ignore[arg-type]


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
    env = env_with(traffic=5)
    seen = {zlib.crc32(env.reset(seed=seed)[0]) for seed in range(3)}
    assert len(seen) == 3


def test_info_is_the_privileged_state() -> None:
    env = env_with(traffic=10)
    _, info = env.reset(seed=0)
    assert set(AFFORDANCES) < set(info)
    assert info["laps"] == 0 and info["damage"] == 0 and info["off_road"] is False
    _, _, _, _, after = env.step(COAST)
    assert after["s"] - info["s"] == pytest.approx(info["speed"] / CONTROL_HZ, rel=0.2)


def test_leaving_the_road_terminates_and_costs_one() -> None:
    env = env_with()
    env.reset(seed=0)
    rewards, terminated, truncated = [], False, False
    while not terminated:
        _, reward, terminated, truncated, info = env.step(np.array([1.0, 0.0], np.float32))
        rewards.append(reward)
    assert info["off_road"] and not truncated
    assert rewards[-1] == -1 and sum(rewards) == -1


def test_a_touch_costs_one_and_the_drive_goes_on() -> None:
    env = env_with(traffic=1)
    env.reset(seed=1)
    assert env.world is not None
    track = env.world.track
    s = straightest(track) - 20.0
    env.world.cars = cars_at(track, [s, s + 8.0], [1, 1], limit=[20.0, 5.0])
    steps = [env.step(COAST) for _ in range(CONTROL_HZ)]
    assert steps[-1][4]["damage"] > 50
    assert sum(step[1] for step in steps) == -1
    assert not any(step[2] or step[3] for step in steps)


def test_time_and_laps_truncate() -> None:
    env = env_with(max_seconds=0.2)
    env.reset(seed=0)
    ends = [env.step(COAST)[2:4] for _ in range(6)]
    assert ends == [(False, False)] * 5 + [(False, True)]
    env = env_with(laps=0.002)
    env.reset(seed=0)
    ends = [env.step(COAST)[2:4] for _ in range(2)]
    assert ends == [(False, False), (False, True)]


def test_the_traffic_follows_its_driver() -> None:
    def brake(cars, track):  # type: ignore[no-untyped-def]
        return np.tile(np.array([0.0, 1.0], np.float32), (len(cars), 1))

    env = DrivingEnv(traffic_driver=brake, traffic=5)
    env.reset(seed=0)
    for _ in range(CONTROL_HZ):
        env.step(COAST)
    assert env.world is not None
    assert env.world.cars.speed[0] > 15 and env.world.cars.speed[1:].max() < 10


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="track 'oak'"):
        env_with(track="oak")
    with pytest.raises(ValueError, match="laps -1"):
        env_with(laps=-1)
    with pytest.raises(ValueError, match="traffic is 1000"):
        env_with(traffic=1000)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env_with().step(COAST)
