import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.merging import merge
from pipeline.data.reading import read_columns, read_episodes
from pipeline.data.schema import CAMERA, COLUMNS, FEATURES, Episode
from pipeline.data.writing import Summary, write_dataset
from tests.data.conftest import strict_json, tree
from tests.data.test_reading import change_feature, cut_short
from tests.episodes import random_episode


@pytest.fixture(scope="module")
def d_1(tmp_path_factory: pytest.TempPathFactory, d_0: Path, rollout_1: Path) -> Path:
    path = tmp_path_factory.mktemp("merged") / "D_1"
    merge([d_0, rollout_1], path)
    return path


def test_merged_are_the_episodes_of_all_in_order(
    d_1: Path, demonstrations: list[Episode], drives: list[Episode]
) -> None:
    merged = list(read_episodes(d_1))
    for episode, part in zip(merged, demonstrations + drives, strict=True):
        assert episode.task == part.task
        for name in FEATURES:
            np.testing.assert_array_equal(episode.columns[name], part.columns[name])
    assert (
        read_columns(d_1, [])["episode_index"].tolist()
        == [0] * 4 + [1] * 3 + [2] * 5 + [3] + [4] * 4
    )


def test_lerobot_loads_the_merged(
    d_1: Path, demonstrations: list[Episode], drives: list[Episode], load: Callable
) -> None:
    dataset = load(d_1)
    rows = [(part, row) for part in demonstrations + drives for row in range(len(part))]
    assert len(dataset) == len(rows)
    assert dataset.num_episodes == 5
    files = [dataset.meta.get_data_file_path(episode).name for episode in range(5)]
    assert files == ["file-000.parquet"] * 2 + ["file-001.parquet"] * 3
    for index, (part, row) in enumerate(rows):
        item = dataset[index]
        assert item["index"] == index
        assert item["task"] == part.task
        image = (item[CAMERA].numpy() * 255).round().astype(np.uint8).transpose(1, 2, 0)
        np.testing.assert_array_equal(image, part.columns[CAMERA][row])
        for name in COLUMNS:
            np.testing.assert_array_equal(
                np.atleast_1d(item[name].numpy()), part.columns[name][row]
            )


def test_statistics_are_those_of_all_finite_values(d_1: Path) -> None:
    statistics = strict_json(d_1 / "meta" / "stats.json")
    columns = read_columns(d_1)
    for name in COLUMNS:
        values = columns[name][np.isfinite(columns[name]).all(axis=1)].astype(float)
        assert statistics[name]["count"] == [len(values)]
        for key in ("min", "max", "mean", "std"):
            expected = getattr(values, key)(axis=0)
            np.testing.assert_allclose(statistics[name][key], expected, atol=1e-6)
    assert statistics["episode_index"]["max"] == [4.0]
    for file in (d_1 / "meta" / "episodes").rglob("*.parquet"):
        table = pq.read_table(file)
        for key in table.column_names:
            if key.startswith("stats/"):
                assert all(np.isfinite(np.array(cell)).all() for cell in table[key].to_pylist())


def test_merging_what_is_merged(d_1: Path, tmp_path: Path) -> None:
    rollout_2 = tmp_path / "rollout_2"
    then = random_episode(np.random.default_rng(2), 6, iteration=2)
    write_dataset(rollout_2, [then], record_every=3)
    summary = merge([d_1, rollout_2], tmp_path / "D_2")
    first, both = read_columns(d_1), read_columns(tmp_path / "D_2")
    for name in COLUMNS:
        np.testing.assert_array_equal(both[name], np.concatenate([first[name], then.columns[name]]))
    queries = int(first["queried"].sum() + then.columns["queried"].sum())
    assert summary == Summary(tmp_path / "D_2", 6, 23, queries)


def test_refuses_frames_that_it_has_already(d_1: Path, rollout_1: Path, tmp_path: Path) -> None:
    message = f"^{rollout_1}: 10 of its frames are in {d_1} too, expected none$"
    with pytest.raises(ValueError, match=message):
        merge([d_1, rollout_1], tmp_path / "D_2")
    assert list(tmp_path.iterdir()) == []


def test_merging_changes_no_input_and_leaves_nothing_else(
    d_0: Path, rollout_1: Path, tmp_path: Path, cache: Path, capfd: pytest.CaptureFixture
) -> None:
    before = tree(d_0), tree(rollout_1)
    merge([d_0, rollout_1], tmp_path / "D_1")
    assert (tree(d_0), tree(rollout_1)) == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["D_1"]
    assert sorted(entry.name for entry in (tmp_path / "D_1").iterdir()) == ["data", "meta"]
    assert not cache.exists(), "LeRobot left something in the user's home"
    assert capfd.readouterr() == ("", "")


def test_refuses_another_frame_rate(d_0: Path, tmp_path: Path) -> None:
    slow = tmp_path / "slow"
    write_dataset(slow, [random_episode(np.random.default_rng(0), 1)], record_every=6)
    with pytest.raises(ValueError, match=f"^{slow}: fps is 5, expected 10 as in {d_0}$"):
        merge([d_0, slow], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == [slow]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (change_feature("action", shape=[3]), "another schema, shape of column 'action'"),
        (cut_short(Path("data", "chunk-000", "file-000.parquet")), "half-written"),
    ],
)
def test_refuses_a_spoilt_input(
    d_0: Path, tmp_path: Path, spoil: Callable[[Path], None], message: str
) -> None:
    other = tmp_path / "other"
    shutil.copytree(d_0, other)
    spoil(other)
    with pytest.raises(ValueError, match=f"^{other}: {message}"):
        merge([d_0, other], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == [other]


def test_refuses_a_missing_input_and_does_not_create_it(d_0: Path, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="there is no such dataset"):
        merge([d_0, tmp_path / "typo"], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == []


def test_refuses_nothing_to_merge(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no datasets to merge, expected at least one path"):
        merge([], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == []


def test_refuses_an_existing_output_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "D_1").mkdir()
    with pytest.raises(FileExistsError, match="D_1: exists already, expected a new path"):
        merge([tmp_path / "missing"], tmp_path / "D_1")
    assert list((tmp_path / "D_1").iterdir()) == []


def test_an_interruption_leaves_nothing(
    d_0: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import lerobot.datasets

    def interrupt(*args: object, output_dir: Path, **kwargs: object) -> None:
        output_dir.mkdir()
        (output_dir / "half").write_text("")
        raise KeyboardInterrupt

    monkeypatch.setattr(lerobot.datasets, "merge_datasets", interrupt)
    with pytest.raises(KeyboardInterrupt):
        merge([d_0], tmp_path / "D_1")
    assert list(tmp_path.iterdir()) == []
