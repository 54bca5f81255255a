"""What was assembled here, in the hands of LeRobot's own loader and tools."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes
from pipeline.data.merging import merge
from pipeline.data.schema import Episode
from pipeline.driving.features import CAMERA, FEATURES, ROBOT_TYPE
from tests.episodes import random_episode, write
from tests.files import strict_json

NOBODY_KNOWS = ("primary_action", "safe_probability", "deviation")  # where the reference drives
NUMBERS = [name for name in FEATURES if name != CAMERA]


def same_rows(a: Dataset, rows: np.ndarray, b: Dataset) -> None:
    """All that `b` has are those of `a`."""
    for name in NUMBERS:
        np.testing.assert_array_equal(b.columns([name])[name], a.columns([name])[name][rows])


@pytest.mark.parametrize("name", ["rollout_1", "d_1", "new_1"])
def test_the_loader_gives_back_every_row(
    name: str, request: pytest.FixtureRequest, load: Callable
) -> None:
    """As it is read here."""
    dataset = request.getfixturevalue(name)
    loaded = load(dataset.path)
    found = (loaded.fps, len(loaded), loaded.num_episodes)
    assert found == (10, len(dataset), len(dataset.lengths))
    items = iter(loaded)
    for _, episode in read_episodes(dataset):
        for row in range(len(episode)):
            item = next(items)
            assert item["task"] == episode.task
            assert item["timestamp"].item() == pytest.approx(row / 10)
            image = (item[CAMERA].numpy() * 255).round().astype(np.uint8)
            np.testing.assert_array_equal(image.transpose(1, 2, 0), episode.columns[CAMERA][row])
            for name in NUMBERS:
                value = np.atleast_1d(item[name].numpy())
                assert value.dtype == FEATURES[name]["dtype"]
                np.testing.assert_array_equal(value, episode.columns[name][row])


def test_recorded_is_what_lerobots_own_writer_records(
    d_0: Dataset, demonstrations: list[Episode], tmp_path: Path
) -> None:
    """Rows byte for byte, pictures too; statistics as exactly as theirs are; the same small files."""
    from lerobot.datasets import LeRobotDataset

    theirs = LeRobotDataset.create(
        "local/x",
        fps=10,
        features=FEATURES,
        root=tmp_path / "x",
        robot_type=ROBOT_TYPE,
        use_videos=False,
        video_backend="pyav",
    )
    for drive in demonstrations:
        for row in range(len(drive)):
            frame = {name: values[row] for name, values in drive.columns.items()}
            theirs.add_frame({**frame, "task": drive.task})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # NaN has no minimum
            theirs.save_episode()
    theirs.finalize()
    other = Dataset.open(tmp_path / "x")

    rows, their_rows = (pq.ParquetFile(d.data_files[0]).read() for d in (d_0, other))
    assert rows.schema.remove_metadata().equals(their_rows.schema.remove_metadata())
    about = [table.schema.metadata[b"huggingface"].decode() for table in (rows, their_rows)]
    assert about[0] == about[1].split(', "fingerprint"')[0] + "}"
    for name in rows.column_names:
        if name != "source.dataset":  # the dataset's id
            assert repr(rows[name].to_pylist()) == repr(their_rows[name].to_pylist()), name
    assert d_0.info == other.info
    tasks = [pq.read_table(d.path / "meta" / "tasks.parquet") for d in (d_0, other)]
    assert tasks[0].equals(tasks[1], check_metadata=True)

    # theirs add up in single precision, and their quantiles are of a histogram
    of_episodes, theirs_of = (pq.read_table(d.episode_files[0]).to_pydict() for d in (d_0, other))
    assert set(of_episodes) == set(theirs_of)
    for name, values in of_episodes.items():
        kind, _, key = name.partition("/")
        if kind != "stats":
            assert values == theirs_of[name], name
        elif key.split("/")[0] not in ("source.dataset", *NOBODY_KNOWS) and "/q" not in key:
            np.testing.assert_allclose(values, theirs_of[name], atol=1e-4, err_msg=name)


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
    drive = random_episode(np.random.default_rng(9), 2, reference_only=True)
    merge([other, write(tmp_path / "more", [drive], "D_safe")], tmp_path / "both")
    assert "primary_action" not in strict_json(tmp_path / "both" / "meta" / "stats.json")


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
