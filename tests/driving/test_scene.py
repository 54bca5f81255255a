"""Scenes are driven in again: that must save time, and be all that can be told of it."""

import weakref
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from pipeline.driving.bullet import pybullet
from pipeline.driving.cars import Cars
from pipeline.driving.environment import DrivingEnv
from pipeline.driving.scene import KEPT, Scene
from pipeline.driving.tracks import Track, make_track
from tests.driving.scenes import cars_at

FULL_THROTTLE = 4.0  # [s] by the reference's steering without its brake: it hits who is ahead


def bumping(env: DrivingEnv, seed: int) -> Iterator[bytes]:
    """All that can be told of each frame of a drive that brakes for nobody."""
    observation, info = env.reset(seed=seed)
    over = False
    while not over:
        hidden = b"".join(value.tobytes() for value in info["hidden"].values())
        outcome = np.array([*env.outcome().values(), *env.label()])
        yield observation["pixels"]["front"].tobytes() + hidden + outcome.tobytes()
        action = env.label() * np.float32([1, 0])
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated


def touching(track: Track, along: float, across: float, angle: float) -> Cars:
    """Two cars, the other ahead of ours by `along` and beside it by `across` [m]."""
    return cars_at(track, [100.0, 100.0 + along], [1, 1], angle=[angle, 0], offset=[0, across])


def env_on(track: str) -> DrivingEnv:
    return DrivingEnv(track=track, traffic=40, action_repeat=3, seconds=FULL_THROTTLE)


@pytest.mark.parametrize("seed", range(3))
def test_a_drive_after_others_is_as_in_a_new_scene(seed: int) -> None:
    track = f"random:{7000 + seed}"  # nobody else has left a scene of it
    used, new = env_on(track), env_on(track)
    for earlier in (seed + 1, seed + 2):
        for _ in bumping(used, earlier):
            if used.world.damage:
                break
    client = used.world.scene.client
    frames = list(zip(bumping(used, seed), bumping(new, seed), strict=True))
    assert used.world.scene.client == client != new.world.scene.client
    assert len(frames) == FULL_THROTTLE * 10
    assert all(one == other for one, other in frames)


def test_who_touched_whom_is_forgotten() -> None:
    """Else cars that lie deep in each other would be pushed as in the drive before."""
    track = make_track("alder")
    scenes = [Scene(track, 2) for _ in range(2)]
    rng = np.random.default_rng(0)
    touched = 0
    for _ in range(1000):
        deep = rng.uniform(0, 4), rng.uniform(0, 1.5), rng.uniform(-0.6, 0.6)
        found = []
        for scene in scenes:
            scene.place(touching(track, *(deep + rng.uniform(-0.05, 0.05, 3))))
            scene.contacts()
            scene.forget()
            scene.place(touching(track, *deep))
            found.append(scene.contacts())
        touched += len(found[0])
        assert repr(found[0]) == repr(found[1])
    assert touched > 900


def test_another_environment_drives_on_in_a_scene_that_was_closed() -> None:
    first, second = env_on("random:7000"), env_on("random:7000")
    expected = list(bumping(first, 5))
    scene = first.world.scene
    first.close()
    assert list(bumping(second, 5)) == expected
    assert second.world.scene is scene


def growth(once: Callable[[int], object], times: int) -> float:
    """[MB] that this process holds more after so many times than after a third of them."""
    held = []
    for number in range(times):
        once(number)
        held.append(int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6)
    return held[-1] - held[times // 3]


def test_memory_is_flat_over_resets_and_over_scenes() -> None:
    """PyBullet does not free all that it is given."""
    env, track = DrivingEnv(traffic=12), make_track("alder")
    assert growth(lambda seed: env.reset(seed=seed), 300) < 2
    assert growth(lambda _: Scene(track, 12).close(), 15) < 8


def test_of_an_environment_that_is_dropped_nothing_is_left() -> None:
    env = DrivingEnv()
    env.reset(seed=0)
    scene, client = weakref.ref(env.world.scene), env.world.scene.client
    assert pybullet.isConnected(client)
    del env
    assert scene() is None and not pybullet.isConnected(client)


def test_only_so_many_scenes_wait() -> None:
    clients = []
    for traffic in range(KEPT + 1):
        env = DrivingEnv(traffic=traffic)
        env.reset(seed=0)
        clients.append(env.world.scene.client)
        env.close()
    assert [bool(pybullet.isConnected(client)) for client in clients] == [False] + [True] * KEPT
