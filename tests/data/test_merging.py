from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes, read_images, read_some_images
from pipeline.data.merging import filled, merge
from pipeline.data.schema import Episode
from pipeline.data.writing import Summary
from pipeline.driving.features import CAMERA, FEATURES
from tests.data.spoiling import DATA, Spoil, change_feature, change_info, copy, drop_column
from tests.episodes import random_episode, write
from tests.files import tree


def test_merged_are_the_episodes_of_all_in_order(
    d_1: Dataset, demonstrations: list[Episode], drives: list[Episode]
) -> None:
    merged = list(read_episodes(d_1))
    for (_, episode), part in zip(merged, demonstrations + drives, strict=True):
        assert episode.task == part.task
        for name in FEATURES.keys() - {"source.dataset"}:
            np.testing.assert_array_equal(episode.columns[name], part.columns[name])
    assert d_1.episode_index.tolist() == [0] * 4 + [1] * 3 + [2] * 5 + [3] + [4] * 4
    rows = [0, 6, 7, 16]  # of both files
    some, every = read_some_images(d_1, CAMERA, rows), read_images(d_1, CAMERA)
    np.testing.assert_array_equal(some, every[rows])


def test_three_at_once_are_what_two_and_one_are(
    d_0: Dataset, rollout_1: Dataset, d_1: Dataset, tmp_path: Path
) -> None:
    then = random_episode(np.random.default_rng(2), 6, iteration=2)
    rollout_2 = write(tmp_path / "rollout_2", [then], "rollout")
    summary = merge([d_1, rollout_2], tmp_path / "D_2")
    queries = sum(int(d.column("queried").sum()) for d in (d_1, rollout_2))
    assert summary == Summary(tmp_path / "D_2", 6, 23, queries)
    merge([d_0, rollout_1, rollout_2], tmp_path / "at_once")
    once, then_d_1, then_d_2, at_once = (
        tree(path / "data") for path in (d_0.path, d_1.path, summary.path, tmp_path / "at_once")
    )
    assert once.items() < then_d_1.items() < then_d_2.items(), "files pass through as they are"
    assert at_once == then_d_2


def test_with_nothing_the_frames_stay_what_they_were(
    d_0: Dataset, nothing: Dataset, tmp_path: Path
) -> None:
    assert merge([d_0, nothing], tmp_path / "D_1") == Summary(tmp_path / "D_1", 2, 7, 7)
    assert tree(tmp_path / "D_1" / "data") == tree(d_0.path / "data")
    merge([Dataset.open(tmp_path / "D_1"), nothing], tmp_path / "D_2")
    again = Dataset.open(tmp_path / "D_2").lineage
    assert again.sha256 not in again.own.parents


def test_columns_that_one_side_lacks_are_filled(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    before = copy(d_0, tmp_path / "before")
    drop_column("asked_because", "ask_probability", "safe_probability", "source.dataset")(before)
    more = copy(rollout_1, tmp_path / "more")
    _add_signal(more)
    datasets = [Dataset.open(before), Dataset.open(more)]
    assert filled(datasets) == {
        before: [
            "safe_probability",
            "asked_because",
            "ask_probability",
            "source.dataset",
            "signal.novelty",
        ]
    }
    merge(datasets, tmp_path / "D_1")
    merged = Dataset.open(tmp_path / "D_1")
    novelty = merged.column("signal.novelty")
    assert np.isnan(novelty[:7]).all() and novelty[7:].tolist() == list(range(10))
    assert np.isnan(merged.column("safe_probability")[:7]).all()
    assert merged.column("ask_probability")[:7].tolist() == [1.0] * 7
    assert merged.column("asked_because")[:7].tolist() == [0] * 7
    assert set(merged.column("source.dataset")[:7].tolist()) == {datasets[0].lineage.id}


def _add_signal(path: Path) -> None:
    table = pq.ParquetFile(path / DATA).read()
    pq.write_table(
        table.append_column("signal.novelty", pa.array(np.arange(len(table), dtype=np.float32))),
        path / DATA,
    )
    change_feature("signal.novelty", dtype="float32", shape=[1], names=None)(path)


def test_refuses_frames_that_it_has_already(
    d_1: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    message = f"^{rollout_1.path}: 10 of its frames are in {d_1.path} too, expected none$"
    with pytest.raises(ValueError, match=message):
        merge([d_1, rollout_1], tmp_path / "D_2")
    assert list(tmp_path.iterdir()) == []


def test_merging_changes_no_input_and_leaves_nothing_else(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    before = tree(d_0.path), tree(rollout_1.path)
    merge([d_0, rollout_1], tmp_path / "D_1")
    assert (tree(d_0.path), tree(rollout_1.path)) == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["D_1"]
    files = sorted(entry.name for entry in (tmp_path / "D_1").iterdir())
    assert files == ["data", "meta", "safedagger.json"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (change_info(fps=5), "fps is 5, expected 10 as in D_0"),
        (change_info(robot_type="so100"), "robot_type is so100, expected safedagger_car as in D_0"),
        (
            change_feature("action", names=["a", "b"]),
            r"column 'action' is float32 \[2\] \['a', 'b'",
        ),
        (change_feature("affordances", names=None), "column 'affordances' is float32"),
        (drop_column("affordances"), "column 'affordances' is missing, expected float32"),
        (
            change_feature("queried", dtype="float32"),
            r"column 'queried' is float32 \[1\], expected",
        ),
    ],
)
def test_refuses_what_does_not_fit(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path, spoil: Spoil, message: str
) -> None:
    other = copy(rollout_1, tmp_path / "other")
    spoil(other)
    named = message.replace("D_0", str(d_0.path))
    with pytest.raises(ValueError, match=f"^{other}: {named}"):
        merge([d_0, Dataset.open(other)], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == [other]


def test_refuses_a_single_dataset_and_a_place_that_is_taken(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="there are 1 datasets to merge, expected at least two"):
        merge([d_0], tmp_path / "D_1")
    with pytest.raises(FileExistsError, match=f"{tmp_path}: exists already, expected a new path"):
        merge([d_0, rollout_1], tmp_path)
    assert list(tmp_path.iterdir()) == []
