"""MetaWorld behind the seam: on a task that its reference has done in 75 frames."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.schema import CORE, column_dtype
from pipeline.environment import Environment, columns_of
from pipeline.policies.measures import deviation, half_range
from pipeline.tasks.metaworld import MetaWorld
from tests.command import run

Make = Callable[..., Environment]

BUTTON = "button-press-topdown-v3"
COLLECT = "collect D_0 --task metaworld --episodes 2 --seed 0 --workers 1"

DRIVE = f"""
import zlib
from pipeline.tasks.metaworld import MetaWorld
env = MetaWorld(tasks="{BUTTON}", perturb=3).environment("{BUTTON}")
seen = 0
observation, info = env.reset(seed=5 + 2**70)
for _ in range(10):
    label = env.label()
    for part in (*observation.values(), label, info["hidden"]["object_state"]):
        seen = zlib.crc32(part.tobytes(), seen)
    observation, *_, info = env.step(label)
env.close()
print("drive", seen)
"""


@pytest.fixture
def made() -> Iterator[Make]:
    """Makes an environment of a task with these settings."""
    environments = []

    def make(tasks: str = BUTTON, **settings: int) -> Environment:
        environments.append(MetaWorld(tasks=tasks, **settings).environment(tasks))
        return environments[-1]

    yield make
    for env in environments:
        env.close()


def by_reference(env: Environment, seed: int = 0) -> tuple[int, dict[str, Any]]:
    """The frames of a drive, and what is told at its end."""
    env.reset(seed=seed)
    over, frames = False, 0
    while not over:
        _, _, terminated, truncated, info = env.step(env.label())
        over, frames = terminated or truncated, frames + 1
        assert terminated == (info["ended"] == "success")
    return frames, info


def test_features_are_what_the_environment_returns(made: Make) -> None:
    env = made()
    observation, info = env.reset(seed=0)
    for _ in range(2):
        assert env.observation_space.contains(observation)
        seen = {**columns_of(observation), **info["hidden"], "action": env.label()}
        assert seen.keys() == MetaWorld.features.keys() - CORE | {"action"}
        for name, value in seen.items():
            feature = MetaWorld.features[name]
            assert (value.dtype, value.shape) == (column_dtype(feature), feature["shape"])
            names = feature["names"]
            assert len(names) == (3 if name == "observation.image" else value.size)
        assert env.action_space.contains(env.label())
        observation, _, _, _, info = env.step(env.label())
    assert env.metadata["render_fps"] == MetaWorld(tasks=BUTTON).fps


def test_the_same_seed_gives_the_same_drive_in_any_process(capfd: pytest.CaptureFixture) -> None:
    exec(DRIVE, {})
    here = capfd.readouterr().out
    there = subprocess.run(
        [sys.executable, "-c", DRIVE], capture_output=True, text=True, check=True
    )
    assert there.stderr == ""
    assert here.split()[-2:] == there.stdout.split()[-2:]


def test_a_drive_does_not_depend_on_the_one_before(made: Make) -> None:
    env = made()
    seen = []
    for _ in range(2):
        env.reset(seed=3)
        seen.append([env.step(env.label())[0] for _ in range(5)])
        by_reference(env, seed=4)
    np.testing.assert_equal(seen[1], seen[0])


def test_environments_beside_each_other_draw_each_its_own(made: Make) -> None:
    env, other = made(), made("push-v3")
    alone = env.reset(seed=0)[0]
    other.reset(seed=0)
    np.testing.assert_equal(env.reset(seed=0)[0], alone)
    other.close()
    np.testing.assert_equal(env.reset(seed=0)[0], alone)


def test_it_is_lerobots_world_at_another_size(made: Make) -> None:
    from lerobot.envs.metaworld import MetaworldEnv

    ours, theirs = made(), MetaworldEnv(BUTTON, obs_type="pixels_agent_pos")
    picture = ours.reset(seed=3)[0]["pixels"]
    expected = cv2.resize(theirs.reset(seed=3)[0]["pixels"], (84, 84), interpolation=cv2.INTER_AREA)
    for _ in range(3):
        label = ours.label()
        state = theirs._env.step(label)[0][:4]
        np.testing.assert_array_equal(ours.step(label)[0]["agent_pos"], state.astype(np.float32))
    theirs.close()
    # without shadows; 27 were its colours, 40 its sides exchanged
    assert np.abs(picture.astype(float) - expected).mean() < 12


@pytest.mark.parametrize("task", [BUTTON, "door-open-v3"])
def test_asking_the_reference_changes_nothing(task: str, made: Make) -> None:
    """MetaWorld's for doors writes into what it is given."""
    quiet, asked = made(task), made(task)
    for env in (quiet, asked):
        env.reset(seed=0)
    for _ in range(4):
        labels = [env() for env in (asked.label, asked.look_up) for _ in range(3)]
        for label in labels[1:]:
            np.testing.assert_array_equal(label, labels[0])
        np.testing.assert_equal(asked.step(labels[0])[0], quiet.step(labels[0])[0])
    np.testing.assert_array_equal(quiet.label(), asked.label())


def test_success_ends_a_drive_and_is_told_before_the_next_begins(made: Make) -> None:
    env = made()
    start = env.reset(seed=0)[1]["hidden"]["object_state"]
    frames, end = by_reference(env)
    assert frames <= 75
    assert (end["ended"], end["failed"]) == ("success", False)
    assert env.outcome() == {"success": True}
    state = end["hidden"]["object_state"]
    np.testing.assert_array_equal(state[-3:], start[-3:])
    assert state[2] < start[2] - 0.05  # the button [m]


def test_time_is_up(made: Make) -> None:
    env = made(steps=3)
    frames, info = by_reference(env)
    assert (frames, info["ended"], info["failed"]) == (3, "out of time", True)
    assert env.outcome() == {"success": False}
    env.reset(seed=0)
    assert env.outcome() == {"success": False}


def test_random_actions_spread_the_starts(made: Make) -> None:
    def places(env: Environment) -> np.ndarray:
        return np.array([env.reset(seed=seed)[0]["agent_pos"][:3] for seed in range(4)])

    still, spread = places(made()), places(made(perturb=20, steps=3))
    assert np.ptp(still, axis=0).max() < 1e-6
    assert np.ptp(spread, axis=0).min() > 0.01  # [m]


def test_the_deviation_is_a_mean_of_squares() -> None:
    proposed = np.array([[1, 0, 0, 0], [1, 1, 1, 1], [np.nan, 0, 0, 0]], np.float32)
    halves = half_range(MetaWorld.features["action"])
    epsilon = deviation(MetaWorld.measure, proposed, -proposed, halves)
    np.testing.assert_array_equal(epsilon, [1, 4, np.nan])


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (f"--tasks {BUTTON},make-coffee", "'make-coffee'"),
        ("--perturb -1", "--perturb"),
        ("--steps 0", "--steps"),
        ("--perturb 400 --steps 101", "perturb is 400 and steps is 101"),
    ],
)
def test_nonsense_is_refused_in_one_line(
    change: str, named: str, refused: Callable[..., str]
) -> None:
    assert named in refused(f"{COLLECT} --tasks {BUTTON} {change}")


def test_help_lists_its_settings_and_not_the_cars(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("collect --task metaworld --help") == 0
    shown = capsys.readouterr().out
    assert all(f"--{name}" in shown for name in ("tasks", "perturb", "steps", "episodes"))
    assert not any(f"--{name}" in shown for name in ("tracks", "traffic", "seconds"))


def test_it_is_collected_into_a_dataset(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from lerobot.datasets import LeRobotDataset

    monkeypatch.chdir(tmp_path)
    assert run(f"{COLLECT} --tasks {BUTTON},reach-v3") == 0
    assert capsys.readouterr().err == ""
    dataset = Dataset.open(Path("D_0"))
    assert dataset.drives.ended.tolist() == ["success"] * 2
    assert dataset.drives[["success", "put_back"]].values.tolist() == [[1, 0]] * 2
    assert dataset.tasks == ["Press a button from the top", "Reach a goal position"]
    assert (dataset.fps, dataset.info["robot_type"]) == (80, "sawyer")
    theirs = LeRobotDataset("local/D_0", root=dataset.path, video_backend="pyav")
    assert (len(theirs), theirs.num_episodes) == (len(dataset), 2)
    row = theirs[0]
    assert row["observation.image"].shape == (3, 84, 84)
    assert row["observation.state"].shape == row["action"].shape == (4,)
    assert row["object_state"].shape == (17,)
