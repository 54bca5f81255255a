import gc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.reading import check_dataset
from pipeline.data.schema import CAMERA, COLUMNS, FEATURES, Episode
from pipeline.data.writing import Summary, write_dataset
from tests.data.conftest import strict_json
from tests.episodes import random_episode


def test_lerobot_loads_what_was_written(
    rollout_1: Path, drives: list[Episode], load: Callable
) -> None:
    dataset = load(rollout_1)
    assert dataset.fps == 10
    assert dataset.num_episodes == 3
    rows = [(drive, row) for drive in drives for row in range(len(drive))]
    assert len(dataset) == len(rows)
    for index, (drive, row) in enumerate(rows):
        item = dataset[index]
        assert item["task"] == drive.task
        assert item["timestamp"].item() == pytest.approx(row / 10)
        image = (item[CAMERA].numpy() * 255).round().astype(np.uint8)
        np.testing.assert_array_equal(image.transpose(1, 2, 0), drive.columns[CAMERA][row])
        for name in COLUMNS:
            value = np.atleast_1d(item[name].numpy())
            assert value.dtype == FEATURES[name]["dtype"]
            np.testing.assert_array_equal(value, drive.columns[name][row])


def test_summary_counts(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    driven, labelled = random_episode(rng, 3, reference_only=True), random_episode(rng, 2)
    labelled.columns["intervention"][:], labelled.columns["queried"][:] = False, [[True], [False]]
    summary = write_dataset(tmp_path / "D", [driven, labelled], record_every=5)
    # a query each: three rows that the reference drove, and one that it only labelled
    assert summary == Summary(tmp_path / "D", episodes=2, frames=5, queries=4)
    assert check_dataset(tmp_path / "D") == 5


def test_leaves_data_and_metadata_and_nothing_else(d_0: Path, cache: Path) -> None:
    assert sorted(entry.name for entry in d_0.iterdir()) == ["data", "meta"]
    assert [entry.name for entry in d_0.parent.iterdir()] == ["D_0"]
    assert not cache.exists(), "LeRobot left something in the user's home"


def test_statistics_are_those_of_the_finite_values(rollout_1: Path, drives: list[Episode]) -> None:
    statistics = strict_json(rollout_1 / "meta" / "stats.json")
    assert set(statistics) >= set(FEATURES)
    for name in COLUMNS:
        values = np.concatenate([drive.columns[name] for drive in drives]).astype(float)
        values = values[np.isfinite(values).all(axis=1)]
        assert statistics[name]["count"] == [len(values)]
        for key in ("min", "max", "mean", "std"):
            expected = getattr(values, key)(axis=0)
            np.testing.assert_allclose(statistics[name][key], expected, atol=1e-6)


def test_statistics_leave_out_a_column_without_values(d_0: Path) -> None:
    statistics = strict_json(d_0 / "meta" / "stats.json")
    without = {"primary_action", "safe_probability", "deviation"}
    assert set(FEATURES) - set(statistics) == without


@pytest.mark.parametrize("name", ["d_0", "rollout_1"])
def test_statistics_of_episodes_are_finite(name: str, request: pytest.FixtureRequest) -> None:
    path = request.getfixturevalue(name)
    (file,) = (path / "meta" / "episodes").rglob("*.parquet")
    table = pq.read_table(file)
    cells = [table[key].to_pylist() for key in table.column_names if key.startswith("stats/")]
    assert cells
    assert all(np.isfinite(np.array(row, float)).all() for column in cells for row in column)


def test_statistics_of_episodes_aggregate_to_those_of_the_dataset(tmp_path: Path) -> None:
    # an episode with no value at all must pull no minimum or mean towards its placeholder
    from lerobot.datasets import aggregate_stats

    rng = np.random.default_rng(0)
    episodes = [random_episode(rng, 4, reference_only=True), random_episode(rng, 9)]
    write_dataset(tmp_path / "D", episodes, record_every=3)
    (file,) = (tmp_path / "D" / "meta" / "episodes").rglob("*.parquet")
    table = pq.read_table(file).to_pydict()
    for name in ("primary_action", "safe_probability", "deviation"):
        prefix = f"stats/{name}/"
        keys = [key.removeprefix(prefix) for key in table if key.startswith(prefix)]
        parts = [{name: {k: np.array(table[prefix + k][e]) for k in keys}} for e in range(2)]
        total = aggregate_stats(parts)[name]
        values = episodes[1].columns[name]
        values = values[np.isfinite(values).all(axis=1)]
        np.testing.assert_allclose(total["min"], values.min(axis=0), rtol=1e-6)
        np.testing.assert_allclose(total["max"], values.max(axis=0), rtol=1e-6)
        np.testing.assert_allclose(total["mean"], values.mean(axis=0), rtol=1e-5)


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("complete", [0, 1])
def test_an_interruption_leaves_nothing(
    tmp_path: Path, error: type[BaseException], complete: int
) -> None:
    def episodes() -> Iterator[Episode]:
        rng = np.random.default_rng(0)
        for _ in range(complete):
            yield random_episode(rng, 2)
        raise error("stop")

    with pytest.raises(error, match="stop"):
        write_dataset(tmp_path / "D", episodes(), record_every=3)
    gc.collect()  # LeRobot flushes what it still holds when it is collected
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_within_an_episode_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lerobot.datasets import LeRobotDataset

    def interrupt(dataset: LeRobotDataset) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(LeRobotDataset, "save_episode", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_dataset(tmp_path / "D", [random_episode(np.random.default_rng(0), 2)], record_every=3)
    gc.collect()
    assert list(tmp_path.iterdir()) == []


def test_refuses_no_episodes(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no episodes, expected at least one frame"):
        write_dataset(tmp_path / "D", [], record_every=3)
    gc.collect()
    assert list(tmp_path.iterdir()) == []


def untouched() -> Iterator[Episode]:
    raise AssertionError("asked for an episode")
    yield


@pytest.mark.parametrize("kind", ["directory", "file", "dangling link"])
def test_refuses_an_existing_path_before_any_work(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "D"
    if kind == "directory":
        path.mkdir()
    elif kind == "file":
        path.write_text("mine")
    else:
        path.symlink_to(tmp_path / "nowhere")
    with pytest.raises(FileExistsError, match=f"{path}: exists already"):
        write_dataset(path, untouched(), record_every=3)
    assert list(tmp_path.iterdir()) == [path]
    assert kind != "file" or path.read_text() == "mine"


def test_refuses_a_record_every_without_a_whole_fps(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="record_every is 4, expected a divisor of 30"):
        write_dataset(tmp_path / "D", untouched(), record_every=4)
    assert list(tmp_path.iterdir()) == []
