import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.data.reading import check_dataset, read_columns, read_episodes, read_images
from pipeline.data.schema import CAMERA, COLUMNS, FEATURES, Episode
from tests.data.conftest import tree

DATA = Path("data", "chunk-000", "file-000.parquet")
EPISODES = Path("meta", "episodes", "chunk-000", "file-000.parquet")


def test_k_is_read_from_the_frame_rate(d_0: Path) -> None:
    assert check_dataset(d_0) == 3


def test_columns_are_what_was_written(rollout_1: Path, drives: list[Episode]) -> None:
    columns = read_columns(rollout_1)
    assert set(columns) == {*COLUMNS, "episode_index", "frame_index"}
    assert columns["episode_index"].tolist() == [0] * 5 + [1] + [2] * 4
    assert columns["frame_index"].tolist() == [*range(5), 0, *range(4)]
    for name in COLUMNS:
        expected = np.concatenate([drive.columns[name] for drive in drives])
        assert columns[name].dtype == expected.dtype
        np.testing.assert_array_equal(columns[name], expected)


def test_some_columns(rollout_1: Path) -> None:
    everything = read_columns(rollout_1)
    some = read_columns(rollout_1, ["source.frame", "action"])
    assert set(some) == {"source.frame", "action", "episode_index", "frame_index"}
    for name, values in some.items():
        np.testing.assert_array_equal(values, everything[name])


def test_images_are_what_was_written(rollout_1: Path, drives: list[Episode]) -> None:
    images = read_images(rollout_1)
    assert images.dtype == np.uint8
    np.testing.assert_array_equal(images, np.concatenate([d.columns[CAMERA] for d in drives]))


def test_episodes_are_what_was_written(rollout_1: Path, drives: list[Episode]) -> None:
    episodes = list(read_episodes(rollout_1))
    assert [episode.task for episode in episodes] == [drive.task for drive in drives]
    for episode, drive in zip(episodes, drives, strict=True):
        for name in FEATURES:
            np.testing.assert_array_equal(episode.columns[name], drive.columns[name])


@pytest.mark.parametrize("name", [CAMERA, "speed", "timestamp"])
def test_refuses_an_unknown_column(d_0: Path, name: str) -> None:
    with pytest.raises(ValueError, match=f"no column is named '{name}', expected some of action"):
        read_columns(d_0, ["action", name])


def change_info(**changes: Any) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        file = path / "meta" / "info.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), **changes}))

    return change


def change_feature(name: str, **changes: Any) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        info = json.loads((path / "meta" / "info.json").read_text())
        features = info["features"]
        features[name] = {**features.get(name, {}), **changes}
        change_info(features=features)(path)

    return change


def drop_feature(path: Path) -> None:
    features = json.loads((path / "meta" / "info.json").read_text())["features"]
    del features["queried"]
    change_info(features=features)(path)


def cut_short(part: Path) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        whole = (path / part).read_bytes()
        (path / part).write_bytes(whole[: len(whole) // 2])

    return change


def lose(part: str | Path) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        victim = path / part
        shutil.rmtree(victim) if victim.is_dir() else victim.unlink()

    return change


def drop_parquet_column(path: Path) -> None:
    pq.write_table(pq.ParquetFile(path / DATA).read().drop_columns(["deviation"]), path / DATA)


SPOILT = {
    "info lost": (lose("meta/info.json"), "not a dataset, expected a directory with meta/info"),
    "info cut": (cut_short(Path("meta", "info.json")), "meta/info.json is not JSON"),
    "other JSON": (
        lambda path: (path / "meta" / "info.json").write_text("[]"),
        "not a LeRobot dataset, meta/info.json has no 'codebase_version'",
    ),
    "old format": (change_info(codebase_version="v2.1"), "LeRobot format v2.1, expected v3.0"),
    "other robot": (change_info(robot_type="so100"), "robot_type is 'so100', expected 'safe"),
    "odd fps": (change_info(fps=7), "fps is 7, expected a divisor of 30"),
    "column lost": (drop_feature, "another schema, column 'queried' is missing"),
    "column more": (
        change_feature("speed", dtype="float32", shape=[1], names=None),
        "another schema, column 'speed' is none of ours",
    ),
    "other shape": (
        change_feature("action", shape=[3]),
        r"another schema, shape of column 'action' is \[3\], expected \[2\]",
    ),
    "other dtype": (
        change_feature("intervention", dtype="float32"),
        "another schema, dtype of column 'intervention' is float32, expected bool",
    ),
    "other names": (
        change_feature("action", names=["steering", "throttle"]),
        r"names of column 'action' is \['steering', 'throttle'\], expected",
    ),
    "data lost": (lose("data"), "half-written, there is no parquet file in data"),
    "data cut": (cut_short(DATA), f"half-written, {DATA} is missing or has no footer"),
    "data short": (
        change_info(total_frames=99),
        "half-written, data has 7 rows, but meta/info.json says total_frames = 99",
    ),
    "data column lost": (drop_parquet_column, f"{DATA} has no column 'deviation'"),
    "episodes lost": (lose("meta/episodes"), "half-written, there is no parquet file in meta/ep"),
    "episodes cut": (cut_short(EPISODES), f"half-written, {EPISODES} is missing or has no footer"),
    "episodes short": (
        change_info(total_episodes=3),
        "half-written, meta/episodes has 2 rows, but meta/info.json says total_episodes = 3",
    ),
    "tasks lost": (lose("meta/tasks.parquet"), "half-written, meta/tasks.parquet is missing"),
    "statistics lost": (lose("meta/stats.json"), "half-written, meta/stats.json is missing"),
}


@pytest.mark.parametrize(("spoil", "message"), SPOILT.values(), ids=SPOILT)
def test_refuses_what_is_no_complete_dataset_of_ours(
    d_0: Path, tmp_path: Path, spoil: Callable[[Path], None], message: str
) -> None:
    path = tmp_path / "D_0"
    shutil.copytree(d_0, path)
    spoil(path)
    before = tree(path)
    for read in (check_dataset, read_columns, read_images, read_episodes):
        with pytest.raises(ValueError, match=message) as caught:
            read(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert "\n" not in str(caught.value)
    assert tree(path) == before


@pytest.mark.parametrize("read", [check_dataset, read_columns, read_images, read_episodes])
def test_refuses_a_missing_path_and_does_not_create_it(tmp_path: Path, read: Callable) -> None:
    with pytest.raises(FileNotFoundError, match=f"^{tmp_path / 'D_9'}: there is no such dataset$"):
        read(tmp_path / "D_9")
    assert list(tmp_path.iterdir()) == []


def test_refuses_a_file_and_an_empty_directory(tmp_path: Path) -> None:
    file, folder = tmp_path / "file", tmp_path / "folder"
    file.write_text("")
    folder.mkdir()
    for path in (file, folder):
        with pytest.raises(ValueError, match=f"^{path}: not a dataset, expected a directory"):
            check_dataset(path)


@pytest.mark.parametrize("png", [b"", b"no PNG", cv2.imencode(".png", np.zeros((9, 9, 3)))[1]])
def test_refuses_an_image_that_is_none_of_ours(d_0: Path, tmp_path: Path, png: Any) -> None:
    path = tmp_path / "D_0"
    shutil.copytree(d_0, path)
    table = pq.ParquetFile(path / DATA).read()
    cells = table[CAMERA].to_pylist()
    cells[-1]["bytes"] = bytes(png)
    position = table.column_names.index(CAMERA)
    spoilt = table.set_column(position, table.field(CAMERA), pa.array(cells, table[CAMERA].type))
    pq.write_table(spoilt, path / DATA)
    with pytest.raises(ValueError, match=f"{DATA}: an image is no PNG of shape"):
        read_images(path)
