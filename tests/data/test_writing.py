from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.dataset import DRIVES, Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.schema import Asked, Episode
from pipeline.data.writing import Summary, write_dataset
from pipeline.driving.features import CAMERA, FEATURES
from tests.episodes import random_episode, write
from tests.files import strict_json

NUMBERS = [name for name in FEATURES if name != CAMERA]


def test_summary_counts(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    driven = random_episode(rng, 3, reference_only=True)
    labelled = random_episode(rng, 2, asked=[Asked.AUDIT, Asked.NOT])
    recipe = Recipe("D_0", {})
    summary = write_dataset(tmp_path / "D", [driven, labelled], recipe, fps=6, robot="car")
    # a query each: three rows that the reference drove, and one that it only labelled
    assert summary == Summary(tmp_path / "D", episodes=2, frames=5, queries=4)
    assert Dataset.open(tmp_path / "D").fps == 6


def test_beside_it_stands_how_each_drive_ended(tmp_path: Path) -> None:
    endings = [{"episode": n, "ended": "road left, hard", "distance": 1.5} for n in (0, 1)]
    rng = np.random.default_rng(0)
    episodes = [replace(random_episode(rng, 2, episode=n), ending=endings[n]) for n in (0, 1)]
    dataset = write(tmp_path / "D", episodes)
    assert dataset.drives.to_dict("records") == endings
    assert write(tmp_path / "E", [random_episode(rng, 2)]).drives.empty
    assert not (tmp_path / "E" / DRIVES).exists()


def test_leaves_data_and_metadata_and_nothing_else(d_0: Dataset) -> None:
    files = sorted(entry.name for entry in d_0.path.iterdir())
    assert files == ["data", "meta", "safedagger.json"]
    assert [entry.name for entry in d_0.path.parent.iterdir()] == ["D_0"]


@pytest.mark.parametrize("name", ["d_0", "rollout_1", "d_1"])
def test_statistics_are_those_of_the_finite_values(
    name: str, request: pytest.FixtureRequest
) -> None:
    """What has none is left out of the dataset's, and stands as some number in an episode's."""
    dataset = request.getfixturevalue(name)
    statistics = strict_json(dataset.path / "meta" / "stats.json")
    for name, column in dataset.columns(NUMBERS).items():
        values = column[np.isfinite(column).all(axis=1)].astype(float)
        assert (name in statistics) == (len(values) > 0)
        if name in statistics:
            assert statistics[name].pop("count") == [len(values)]
            if (values == values[0]).all():
                values = values[:1]  # what adding up large ones would round
            for key in ("min", "max", "mean", "std"):
                expected = getattr(values, key)(axis=0)
                np.testing.assert_allclose(statistics[name][key], expected, atol=1e-6)
    assert statistics["episode_index"]["max"] == [len(dataset.lengths) - 1]
    (file,) = dataset.episode_files
    table = pq.read_table(file)
    cells = [table[key].to_pylist() for key in table.column_names if key.startswith("stats/")]
    assert cells
    assert all(np.isfinite(np.array(row, float)).all() for column in cells for row in column)


def test_statistics_of_episodes_aggregate_to_those_of_the_dataset(tmp_path: Path) -> None:
    # an episode with no value at all must pull no minimum or mean towards its placeholder
    from lerobot.datasets import aggregate_stats

    rng = np.random.default_rng(0)
    episodes = [random_episode(rng, 4, reference_only=True), random_episode(rng, 9)]
    (file,) = write(tmp_path / "D", episodes).episode_files
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
        write(tmp_path / "D", episodes())
    assert list(tmp_path.iterdir()) == []


def test_refuses_no_episodes(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no episodes, expected at least one frame"):
        write(tmp_path / "D", [])
    assert list(tmp_path.iterdir()) == []


def _with(drive: Episode, name: str, **changes: Any) -> Episode:
    """A drive one of whose columns is described in another way."""
    return replace(drive, features={**FEATURES, name: {**FEATURES[name], **changes}})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: [_with(d, CAMERA, dtype="video")], r"is video \[72, 160, 3\], expected image"),
        (
            lambda d: [d, _with(d, "action", names=["a", "b"])],
            "the episodes differ in their columns",
        ),
    ],
)
def test_refuses_what_it_cannot_record(tmp_path: Path, change: Callable, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        write(tmp_path / "D", change(random_episode(np.random.default_rng(0), 2)))
    assert list(tmp_path.iterdir()) == []


def test_refuses_an_existing_path_before_any_work(tmp_path: Path) -> None:
    def untouched() -> Iterator[Episode]:
        raise AssertionError("asked for an episode")
        yield

    with pytest.raises(FileExistsError, match=f"{tmp_path}: exists already"):
        write(tmp_path, untouched())
