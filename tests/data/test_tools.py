"""What was assembled here, in the hands of LeRobot's own loader and tools."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.merging import merge
from pipeline.data.selecting import select
from pipeline.driving.features import CAMERA, FEATURES
from tests.data.conftest import strict_json

NUMBERS = [name for name in FEATURES if name != CAMERA]


@pytest.fixture
def new_1(rollout_1: Dataset, tmp_path: Path) -> Dataset:
    select(rollout_1, tmp_path / "new_1")
    return Dataset.open(tmp_path / "new_1")


def same_rows(a: Dataset, rows: np.ndarray, b: Dataset) -> None:
    """All that `b` has are those of `a`."""
    for name in NUMBERS:
        np.testing.assert_array_equal(b.columns([name])[name], a.columns([name])[name][rows])


def test_the_loader_gives_back_every_row(new_1: Dataset, load: Callable) -> None:
    loaded = load(new_1.path)
    assert (len(loaded), loaded.num_episodes) == (len(new_1), len(new_1.lengths))
    for index in range(len(new_1)):
        for name in NUMBERS:
            value = np.atleast_1d(loaded[index][name].numpy())
            np.testing.assert_array_equal(value, new_1.columns([name])[name][index])


def test_a_file_is_described_as_lerobots_writer_does(d_0: Dataset, tmp_path: Path) -> None:
    """The types and the metadata of the rows, and what the small files hold."""
    from lerobot.datasets import LeRobotDataset

    theirs = LeRobotDataset.create(
        "local/x", fps=10, features=FEATURES, root=tmp_path / "x", use_videos=False
    )
    for row in range(2):
        frame = {name: d_0.columns([name])[name][row] for name in NUMBERS}
        frame[CAMERA] = np.zeros((72, 160, 3), np.uint8)
        theirs.add_frame({**frame, "task": "a task"})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # NaN has no minimum
        theirs.save_episode()
    theirs.finalize()
    ours, other = Dataset.open(d_0.path), Dataset.open(tmp_path / "x")
    schemas = [pq.read_schema(dataset.data_files[0]) for dataset in (ours, other)]
    assert schemas[0].remove_metadata().equals(schemas[1].remove_metadata())
    about = [dict(schema.metadata)[b"huggingface"].decode() for schema in schemas]
    assert about[0] == about[1].split(', "fingerprint"')[0] + "}"
    assert set(ours.info) == set(other.info)
    assert ours.info["features"] == other.info["features"]
    tasks = [pq.read_schema(d.path / "meta" / "tasks.parquet") for d in (ours, other)]
    assert tasks[0].equals(tasks[1])
    columns = [set(pq.read_schema(d.episode_files[0]).names) for d in (ours, other)]
    assert columns[0] == columns[1]


def test_episodes_can_be_deleted(new_1: Dataset, tmp_path: Path, load: Callable) -> None:
    from lerobot.datasets.dataset_tools import delete_episodes

    delete_episodes(load(new_1.path), [0], output_dir=tmp_path / "less", repo_id="local/less")
    less = Dataset.open(tmp_path / "less")
    same_rows(new_1, np.arange(len(new_1)) >= new_1.lengths[0], less)
    strict_json(less.path / "meta" / "stats.json")


def test_statistics_stay_free_of_nan_where_nothing_has_a_value(
    d_0: Dataset, tmp_path: Path, load: Callable
) -> None:
    from lerobot.datasets.dataset_tools import delete_episodes

    delete_episodes(load(d_0.path), [1], output_dir=tmp_path / "less", repo_id="local/less")
    statistics = strict_json(tmp_path / "less" / "meta" / "stats.json")
    action = d_0.columns(["action"])["action"][:4]
    np.testing.assert_allclose(statistics["action"]["mean"], action.mean(axis=0), atol=1e-6)
    # and whoever merges it here gets those of what there is
    other = Dataset.open(tmp_path / "less")
    merge([other, _renamed(d_0, tmp_path)], tmp_path / "both")
    assert "primary_action" not in strict_json(tmp_path / "both" / "meta" / "stats.json")


def _renamed(d_0: Dataset, tmp_path: Path) -> Dataset:
    """Other frames of the same robot."""
    from tests.episodes import random_episode, write

    rng = np.random.default_rng(9)
    return write(tmp_path / "more", [random_episode(rng, 2, reference_only=True)], "D_safe")


def test_lerobot_merges_what_is_merged(
    d_0: Dataset, new_1: Dataset, tmp_path: Path, load: Callable
) -> None:
    from lerobot.datasets import merge_datasets

    merge_datasets([load(d_0.path), load(new_1.path)], "local/m", output_dir=tmp_path / "theirs")
    merge([d_0, new_1], tmp_path / "ours")
    ours, theirs = Dataset.open(tmp_path / "ours"), Dataset.open(tmp_path / "theirs")
    same_rows(ours, np.arange(len(ours)), theirs)
    assert ours.tasks == theirs.tasks and ours.features == theirs.features
    assert ours.lengths.tolist() == theirs.lengths.tolist()
