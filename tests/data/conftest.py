"""Datasets that several tests read, written once."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.merging import merge
from pipeline.data.schema import Asked, Episode
from pipeline.data.selecting import select
from tests.episodes import JUDGED, random_episode, write


@pytest.fixture
def load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable:
    """LeRobot's own loader."""
    from lerobot.datasets import LeRobotDataset

    monkeypatch.setattr("datasets.config.HF_DATASETS_CACHE", tmp_path / "lerobot_cache")
    return lambda path: LeRobotDataset("local/test", root=path, video_backend="pyav")


@pytest.fixture(scope="session")
def demonstrations() -> list[Episode]:
    """Iteration 0: two drives of the reference, on two tracks."""
    rng = np.random.default_rng(0)
    return [
        random_episode(rng, 4, task="coast, no cars", episode=0, reference_only=True),
        random_episode(rng, 3, task="hills, 20 cars", episode=1, reference_only=True),
    ]


@pytest.fixture(scope="session")
def drives() -> list[Episode]:
    """Iteration 1: three drives of primary and reference, one of a single row, one track new."""
    rng = np.random.default_rng(1)
    return [
        random_episode(rng, 5, task="forest, 5 cars", iteration=1, episode=0),
        random_episode(rng, 1, task="coast, no cars", iteration=1, episode=1),
        random_episode(rng, 4, task="forest, 5 cars", iteration=1, episode=2),
    ]


@pytest.fixture(scope="session")
def d_0(tmp_path_factory: pytest.TempPathFactory, demonstrations: list[Episode]) -> Dataset:
    """`demonstrations` at 10 frames per second. Do not change it."""
    return write(tmp_path_factory.mktemp("datasets") / "D_0", demonstrations)


@pytest.fixture(scope="session")
def rollout_1(tmp_path_factory: pytest.TempPathFactory, drives: list[Episode]) -> Dataset:
    """`drives` at 10 frames per second. Do not change it."""
    path = tmp_path_factory.mktemp("datasets") / "rollout_1"
    return write(path, drives, "rollout", **JUDGED)


@pytest.fixture(scope="session")
def new_1(tmp_path_factory: pytest.TempPathFactory, rollout_1: Dataset) -> Dataset:
    """What was asked in `rollout_1`. Do not change it."""
    path = tmp_path_factory.mktemp("datasets") / "new_1"
    select(rollout_1, path)
    return Dataset.open(path)


@pytest.fixture(scope="session")
def d_1(tmp_path_factory: pytest.TempPathFactory, d_0: Dataset, rollout_1: Dataset) -> Dataset:
    """`d_0` and `rollout_1`. Do not change it."""
    path = tmp_path_factory.mktemp("datasets") / "D_1"
    merge([d_0, rollout_1], path)
    return Dataset.open(path)


@pytest.fixture(scope="session")
def unasked(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """A rollout in which nobody was asked. Do not change it."""
    drive = random_episode(np.random.default_rng(0), 4, iteration=1, asked=[Asked.NOT] * 4)
    return write(tmp_path_factory.mktemp("datasets") / "unasked", [drive], "rollout")


@pytest.fixture(scope="session")
def nothing(tmp_path_factory: pytest.TempPathFactory, unasked: Dataset) -> Dataset:
    """What was asked in `unasked`. Do not change it."""
    path = tmp_path_factory.mktemp("datasets") / "nothing"
    select(unasked, path)
    return Dataset.open(path)
