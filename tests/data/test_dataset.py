from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest

from pipeline.data.blocks import GROUP
from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes, read_images, read_some_images
from pipeline.data.schema import CORE, Asked, Episode
from pipeline.driving.features import CAMERA, FEATURES, IMITATED
from tests.data.spoiling import (
    DATA,
    EPISODES,
    Spoil,
    change_feature,
    change_info,
    copy,
    cut_short,
    drop_column,
    drop_parquet_column,
    lose,
    set_column,
    set_last_image,
)
from tests.episodes import random_episode, write
from tests.files import tree

NUMBERS = [name for name in FEATURES if name != CAMERA]


def test_it_knows_what_it_is(d_0: Dataset, rollout_1: Dataset, drives: list[Episode]) -> None:
    assert (d_0.fps, len(d_0), d_0.lengths.tolist()) == (10, 7, [4, 3])
    assert rollout_1.tasks == [drive.task for drive in drives]
    assert rollout_1.bounds == [(0, 5), (5, 6), (6, 10)]
    assert rollout_1.episode_index.tolist() == [0] * 5 + [1] + [2] * 4
    assert rollout_1.cameras == [CAMERA]
    assert rollout_1.features == FEATURES


def test_columns_are_what_was_written(rollout_1: Dataset, drives: list[Episode]) -> None:
    columns = rollout_1.columns([*NUMBERS, "frame_index"])
    assert columns["frame_index"][:, 0].tolist() == [*range(5), 0, *range(4)]
    for name in NUMBERS:
        expected = np.concatenate([drive.columns[name] for drive in drives])
        if name == "source.dataset":
            expected[:] = rollout_1.lineage.id
        assert columns[name].dtype == expected.dtype
        np.testing.assert_array_equal(columns[name], expected)


@pytest.mark.parametrize("kept", [0, 4, 10])
def test_images_are_what_was_written(
    rollout_1: Dataset, drives: list[Episode], kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many of them are kept, whatever is asked for in which order, and again."""
    monkeypatch.setattr("pipeline.data.images.KEPT", kept * 72 * 160 * 3)
    images = read_images(rollout_1, CAMERA)
    expected = np.concatenate([drive.columns[CAMERA] for drive in drives])
    assert (images.dtype, images.shape, len(images)) == (np.uint8, expected.shape, len(expected))
    for rows in (np.array([7, 2, 7, 3]), slice(2, 9), np.array([], int), slice(None), [0, 9]):
        np.testing.assert_array_equal(images[rows], expected[rows])
    some = read_some_images(rollout_1, CAMERA, [1, 5, 6, 9])
    np.testing.assert_array_equal(some, expected[[1, 5, 6, 9]])


@pytest.mark.parametrize("only", [None, [1], [0, 2]])
def test_episodes_are_what_was_written(
    rollout_1: Dataset, drives: list[Episode], only: list[int] | None
) -> None:
    numbers = [0, 1, 2] if only is None else only
    read = list(read_episodes(rollout_1, only))
    assert [number for number, _ in read] == numbers
    for number, episode in read:
        assert episode.task == drives[number].task
        for name in FEATURES.keys() - {"source.dataset"}:
            np.testing.assert_array_equal(episode.columns[name], drives[number].columns[name])


def test_of_other_episodes_nothing_is_read(tmp_path: Path) -> None:
    """Their rows may even be damaged."""
    rng = np.random.default_rng(0)
    drives = [random_episode(rng, GROUP, episode=number) for number in range(2)]
    dataset = write(tmp_path / "D", drives)
    (file,) = dataset.data_files
    content, first = bytearray(file.read_bytes()), pq.read_metadata(file).row_group(0)
    columns = [first.column(number) for number in range(first.num_columns)]
    for column in columns:
        if column.path_in_schema.split(".")[0] in (CAMERA, "action", "queried"):
            start = column.dictionary_page_offset or column.data_page_offset
            content[start : start + column.total_compressed_size] = (
                b"x" * column.total_compressed_size
            )
    file.write_bytes(content)
    ((number, episode),) = read_episodes(dataset, [1])
    assert number == 1
    for name in (CAMERA, "action", "queried"):
        np.testing.assert_array_equal(episode.columns[name], drives[1].columns[name])
    (image,) = read_some_images(dataset, CAMERA, [GROUP + 3])
    np.testing.assert_array_equal(image, drives[1].columns[CAMERA][3])


@pytest.mark.parametrize("name", [CAMERA, "speed", ""])
def test_refuses_an_unknown_column(d_0: Dataset, name: str) -> None:
    with pytest.raises(ValueError, match=f"^{d_0.path}: has no column '{name}'"):
        d_0.columns(["action", name])


def test_a_reader_asks_for_the_columns_that_it_needs(d_0: Dataset, tmp_path: Path) -> None:
    d_0.require(IMITATED)
    spoilt = copy(d_0, tmp_path / "D")
    drop_column("affordances")(spoilt)
    with pytest.raises(
        ValueError, match=f"^{spoilt}: column 'affordances' is missing, expected fl"
    ):
        Dataset.open(spoilt).require(IMITATED)
    change_feature("action", names=["steering", "throttle"])(spoilt)
    message = r"column 'action' is float32 \[2\] \['steering', 'throttle'\], expected .*'brake'\]"
    with pytest.raises(ValueError, match=message):
        Dataset.open(spoilt).require({"action": FEATURES["action"]})


def test_core_columns_that_nobody_wrote_down_are_derived(
    rollout_1: Dataset, tmp_path: Path
) -> None:
    bare = copy(rollout_1, tmp_path / "bare")
    drop_column(*(set(CORE) - {"action", "intervention"}))(bare)
    lose("safedagger.json")(bare)
    dataset = Dataset.open(bare)
    assert dataset.lineage.own.purpose == "foreign"
    drove = rollout_1.column("intervention")
    assert dataset.column("queried").tolist() == drove.tolist()
    assert dataset.column("asked_because").tolist() == [
        Asked.DROVE if each else Asked.NOT for each in drove
    ]
    assert set(dataset.column("source.dataset").tolist()) == {dataset.lineage.id}
    assert dataset.column("source.episode").tolist() == dataset.episode_index.tolist()
    assert dataset.column("source.frame").tolist() == [*range(5), 0, *range(4)]
    assert dataset.column("source.iteration").tolist() == [-1] * 10
    assert np.isnan(dataset.columns(["primary_action"])["primary_action"]).all()
    assert np.isnan(dataset.column("safe_probability")).all()


SPOILT: dict[str, tuple[Spoil, str]] = {
    "info lost": (lose("meta/info.json"), "not a dataset, expected a directory with meta/info"),
    "info cut": (cut_short(Path("meta", "info.json")), "meta/info.json is not JSON"),
    "other JSON": (
        lambda path: (path / "meta" / "info.json").write_text("[]") and None,
        "not a LeRobot dataset, meta/info.json has no 'codebase_version'",
    ),
    "old format": (change_info(codebase_version="v2.1"), "LeRobot format v2.1, expected v3.0"),
    "odd fps": (change_info(fps=0), "fps is 0, expected a whole number of at least 1"),
    "no action": (drop_column("action"), "not a policy's dataset, it has no column 'action'"),
    "data lost": (lose("data"), "half-written, there is no parquet file in data"),
    "data cut": (cut_short(DATA), f"half-written, {DATA} is missing or has no footer"),
    "data short": (
        change_info(total_frames=99),
        "half-written, data has 7 rows, but meta/info.json says total_frames = 99",
    ),
    "data column lost": (drop_parquet_column("deviation"), f"{DATA} has no column 'deviation'"),
    "episodes lost": (lose("meta/episodes"), "half-written, there is no parquet file in meta/ep"),
    "episodes cut": (cut_short(EPISODES), f"half-written, {EPISODES} is missing or has no footer"),
    "episodes short": (
        change_info(total_episodes=3),
        "half-written, meta/episodes has 2 rows, but meta/info.json says total_episodes = 3",
    ),
    "a column without a shape": (
        change_info(features={"action": {"dtype": "float32"}}),
        "meta/info.json says no dtype or no shape of 'action'",
    ),
    "tasks lost": (lose("meta/tasks.parquet"), "half-written, meta/tasks.parquet is missing"),
    "statistics lost": (lose("meta/stats.json"), "half-written, meta/stats.json is missing"),
    "rows swapped": (
        set_column(DATA, "index", lambda rows: rows[::-1]),
        "index of row 0 is 6, expected 0",
    ),
    "episode in pieces": (
        set_column(DATA, "episode_index", lambda _: [0, 1, 0, 1, 0, 1, 0]),
        "episode_index of row 2 is 0, expected 2",
    ),
    "gap in an episode": (
        set_column(DATA, "frame_index", lambda _: [0, 1, 2, 4, 0, 1, 2]),
        "frame_index of row 3 is 4, expected 3",
    ),
    "bounds swapped": (
        set_column(EPISODES, "dataset_from_index", lambda rows: rows[::-1]),
        "meta/episodes says dataset_from_index = 4 of episode 0, but by the data it is 0",
    ),
    "length changed": (
        set_column(EPISODES, "length", lambda _: [4, 9]),
        "meta/episodes says length = 9 of episode 1, but by the data it is 3",
    ),
    "another file": (
        set_column(EPISODES, "data/file_index", lambda _: [0, 1]),
        "meta/episodes says data/file_index = 1 of episode 1, but by the data it is 0",
    ),
    "task unknown": (
        set_column(DATA, "task_index", lambda rows: [7, *rows[1:]]),
        "meta/tasks.parquet has no task 7, but data has",
    ),
}


@pytest.mark.parametrize(("spoil", "message"), SPOILT.values(), ids=SPOILT)
def test_refuses_what_is_no_complete_dataset(
    d_0: Dataset, tmp_path: Path, spoil: Spoil, message: str
) -> None:
    path = copy(d_0, tmp_path / "D_0")
    spoil(path)
    before = tree(path)
    with pytest.raises(ValueError, match=message) as caught:
        Dataset.open(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    assert tree(path) == before


def test_refuses_a_missing_path_and_does_not_create_it(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=f"^{tmp_path / 'D_9'}: there is no such dataset$"):
        Dataset.open(tmp_path / "D_9")
    assert list(tmp_path.iterdir()) == []


def test_refuses_a_file_and_an_empty_directory(tmp_path: Path) -> None:
    file, folder = tmp_path / "file", tmp_path / "folder"
    file.write_text("")
    folder.mkdir()
    for path in (file, folder):
        with pytest.raises(ValueError, match=f"^{path}: not a dataset, expected a directory"):
            Dataset.open(path)


@pytest.mark.parametrize("png", [b"", b"no PNG", cv2.imencode(".png", np.zeros((9, 9, 3)))[1]])
@pytest.mark.parametrize(
    "read",
    [lambda d: read_images(d, CAMERA)[:], lambda d: list(read_episodes(d))],
    ids=["images", "episodes"],
)
def test_refuses_an_image_of_another_kind(
    d_0: Dataset, tmp_path: Path, png: Any, read: Callable
) -> None:
    path = copy(d_0, tmp_path / "D_0")
    set_last_image(bytes(png))(path)
    with pytest.raises(ValueError, match=f"^{path}: {CAMERA}: an image is no PNG of shape"):
        read(Dataset.open(path))
