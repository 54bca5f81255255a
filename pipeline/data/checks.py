"""Whether a directory is a complete LeRobot v3.0 dataset. In the shapes, E is its episodes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data.schema import LEROBOT_COLUMNS, PICTURES
from pipeline.data.stored import data_files, episode_files, first_rows, numbers

FORMAT = "v3.0"
NEEDED = ("codebase_version", "robot_type", "fps", "features", "total_frames", "total_episodes")


def read_info(path: Path) -> dict[str, Any]:
    """meta/info.json of the dataset in `path`; FileNotFoundError where there is nothing, ValueError where
    it is no LeRobot dataset, or of another format.
    """
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such dataset")
    file = path / "meta" / "info.json"
    if not file.is_file():
        raise ValueError(f"{path}: not a dataset, expected a directory with meta/info.json")
    try:
        info = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: meta/info.json is not JSON ({error})") from error
    for key in NEEDED:
        if key not in info:
            raise ValueError(f"{path}: not a LeRobot dataset, meta/info.json has no {key!r}")
    if info["codebase_version"] != FORMAT:
        raise ValueError(f"{path}: LeRobot format {info['codebase_version']}, expected {FORMAT}")
    if not isinstance(info["fps"], int) or info["fps"] < 1:
        raise ValueError(f"{path}: fps is {info['fps']}, expected a whole number of at least 1")
    for name, feature in info["features"].items():
        if not isinstance(feature, dict) or not {"dtype", "shape"} <= feature.keys():
            raise ValueError(f"{path}: meta/info.json says no dtype or no shape of {name!r}")
    if "action" not in info["features"]:
        raise ValueError(f"{path}: not a policy's dataset, it has no column 'action'")
    return info


def check_complete(path: Path, info: dict[str, Any]) -> None:
    """LeRobot writes info.json first and the parquet footers last: whatever disagrees was cut, and a
    ValueError names it.
    """
    files = {"data": data_files(path), "meta/episodes": episode_files(path)}
    for folder, expected in (("data", "total_frames"), ("meta/episodes", "total_episodes")):
        if not files[folder]:
            raise ValueError(f"{path}: half-written, there is no parquet file in {folder}")
        rows = sum(_rows_in_footer(path, file) for file in files[folder])
        if rows != info[expected]:
            raise ValueError(
                f"{path}: half-written, {folder} has {rows} rows, "
                f"but meta/info.json says {expected} = {info[expected]}"
            )
    _rows_in_footer(path, path / "meta" / "tasks.parquet")
    if not (path / "meta" / "stats.json").is_file():
        raise ValueError(f"{path}: half-written, meta/stats.json is missing")
    stored = [name for name, of in info["features"].items() if of["dtype"] != PICTURES[1]]
    for file in files["data"]:
        names = pq.read_schema(file).names
        for name in (*stored, *LEROBOT_COLUMNS):
            if name not in names:
                part = file.relative_to(path)
                raise ValueError(f"{path}: half-written, {part} has no column {name!r}")


def check_episodes(path: Path) -> tuple[NDArray[np.int64], list[str]]:
    """The length [E] and the task of each episode; ValueError where meta/episodes says other bounds,
    lengths or files than the rows, or these are not numbered one by one.
    """
    rows = {
        name: values[:, 0] for name, values in numbers(data_files(path), LEROBOT_COLUMNS).items()
    }
    episode, index = rows["episode_index"], np.arange(len(rows["index"]))
    firsts = np.flatnonzero(np.diff(episode, prepend=-1))
    lengths = np.diff(firsts, append=len(index))
    place = index - np.repeat(firsts, lengths)
    for name, expected in (
        ("index", index),
        ("episode_index", np.repeat(np.arange(len(firsts)), lengths)),
        ("frame_index", place),
    ):
        wrong = np.flatnonzero(rows[name] != expected)
        if len(wrong):
            row = wrong[0]
            raise ValueError(
                f"{path}: {name} of row {row} is {rows[name][row]}, expected {expected[row]}"
            )
    _check_metadata(path, firsts, lengths)
    tasks = pq.ParquetFile(path / "meta" / "tasks.parquet").read().to_pydict()
    # LeRobot takes an index without a name, too
    texts = tasks.get("task", tasks.get("__index_level_0__"))
    if texts is None or "task_index" not in tasks:
        raise ValueError(f"{path}: meta/tasks.parquet has no tasks, expected task and task_index")
    names = dict(zip(tasks["task_index"], texts, strict=True))
    unknown = set(rows["task_index"].tolist()) - names.keys()
    if unknown:
        raise ValueError(f"{path}: meta/tasks.parquet has no task {min(unknown)}, but data has")
    return lengths.astype(np.int64), [names[task] for task in rows["task_index"][firsts].tolist()]


def _check_metadata(path: Path, firsts: NDArray[np.int64], lengths: NDArray[np.int64]) -> None:
    """Whether meta/episodes says of each episode what the rows do."""
    files = data_files(path)
    of_episode = np.searchsorted(first_rows(files), firsts, side="right") - 1
    chunks = np.array([int(file.parent.name.rpartition("-")[2]) for file in files])
    in_chunk = np.array([int(file.stem.rpartition("-")[2]) for file in files])
    expected = {
        "episode_index": np.arange(len(firsts)),
        "length": lengths,
        "dataset_from_index": firsts,
        "dataset_to_index": firsts + lengths,
        "data/chunk_index": chunks[of_episode],
        "data/file_index": in_chunk[of_episode],
    }
    tables = [pq.ParquetFile(file).read(list(expected)) for file in episode_files(path)]
    said = pa.concat_tables(tables).to_pydict()
    for name, values in expected.items():
        for episode, (found, right) in enumerate(zip(said[name], values.tolist(), strict=True)):
            if found != right:
                raise ValueError(
                    f"{path}: meta/episodes says {name} = {found} of episode {episode}, "
                    f"but by the data it is {right}"
                )


def _rows_in_footer(path: Path, file: Path) -> int:
    try:
        return pq.read_metadata(file).num_rows
    except (pa.ArrowException, OSError) as error:
        part = file.relative_to(path)
        raise ValueError(f"{path}: half-written, {part} is missing or has no footer") from error
