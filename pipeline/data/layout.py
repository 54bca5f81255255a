"""How LeRobot's format v3.0 lays out a dataset: the types of its columns, and its small files."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from pipeline.data.schema import LEROBOT_COLUMNS, PICTURES, Feature

DATA_FILE = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES_FILE = Path("meta/episodes/chunk-000/file-000.parquet")
VIDEO_FILE = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
CHUNK = 1000  # files in a folder
FILE_MB = 100  # in a data file, about

_IMAGE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])


def place(number: int) -> dict[str, int]:
    """The chunk and the number in it of the `number`th file of a kind, by LeRobot's names."""
    return {"chunk_index": number // CHUNK, "file_index": number % CHUNK}


def arrow_schema(features: Mapping[str, Feature]) -> pa.Schema:
    """Of the rows with the columns `features`, and LeRobot's own; a video has no column."""
    stored = {name: of for name, of in features.items() if of["dtype"] != PICTURES[1]}
    columns = {**stored, **LEROBOT_COLUMNS}
    about = {"info": {"features": {name: _described(of) for name, of in columns.items()}}}
    return pa.schema(
        [(name, arrow_type(of)) for name, of in columns.items()],
        metadata={"huggingface": json.dumps(about)},
    )


def arrow_type(feature: Feature) -> pa.DataType:
    """Of a column."""
    if feature["dtype"] in PICTURES:
        return _IMAGE
    kind = pa.from_numpy_dtype(feature["dtype"]) if feature["dtype"] != "string" else pa.string()
    shape = feature["shape"]
    if shape == (1,):
        return kind
    if len(shape) == 1:
        return pa.list_(pa.field("element", kind), shape[0])
    for _ in shape:
        kind = pa.list_(pa.field("element", kind))
    return kind


def to_arrow(values: NDArray, kind: pa.DataType) -> pa.Array:
    """A column [T, *shape] of numbers or text as it is stored."""
    if not (pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind)):
        return pa.array(values.ravel(), kind)
    rows, width = values.shape[:2]
    each = to_arrow(values.reshape(rows * width, *values.shape[2:]), kind.value_type)
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(each, type=kind)
    return pa.ListArray.from_arrays(np.arange(rows + 1, dtype=np.int32) * width, each, type=kind)


def _described(feature: Feature) -> dict[str, Any]:
    """As the library `datasets` writes it into the metadata of a parquet file."""
    if feature["dtype"] in PICTURES:
        return {"_type": "Image"}
    value = {"dtype": feature["dtype"], "_type": "Value"}
    shape = list(feature["shape"])
    if shape == [1]:
        return value
    if len(shape) == 1:
        return {"feature": value, "length": shape[0], "_type": "List"}
    return {"shape": shape, "dtype": feature["dtype"], "_type": f"Array{len(shape)}D"}


def write_tasks(root: Path, tasks: Sequence[str]) -> None:
    """meta/tasks.parquet, as LeRobot writes it: an index with pandas' metadata."""
    import pandas as pd

    index = pd.Index(list(tasks), name="task", dtype="object")
    frame = pd.DataFrame({"task_index": pd.Series(range(len(tasks)), index, "int64")})
    frame.to_parquet(root / "meta" / "tasks.parquet")


def write_json(file: Path, content: Mapping[str, Any], *, sort_keys: bool = False) -> None:
    """As LeRobot writes it, but strict: NaN is an error."""
    text = json.dumps(content, indent=4, ensure_ascii=False, allow_nan=False, sort_keys=sort_keys)
    file.write_text(text + "\n", encoding="utf-8")


def write_statistics(root: Path, known: Mapping[str, Mapping[str, NDArray]]) -> None:
    """meta/stats.json, of the columns of which something is known."""
    content = {name: {k: v.tolist() for k, v in of.items()} for name, of in known.items()}
    write_json(root / "meta" / "stats.json", content, sort_keys=True)


def new_info(fps: int, robot: str) -> dict[str, Any]:
    """meta/info.json of a dataset of which only that is known, as LeRobot begins it."""
    counts = dict.fromkeys(("total_episodes", "total_frames", "total_tasks"), 0)
    sizes = {"data_files_size_in_mb": FILE_MB, "video_files_size_in_mb": 200}
    begun = {"codebase_version": "v3.0", "fps": fps, "features": {}, **counts, "chunks_size": CHUNK}
    return {**begun, **sizes, "data_path": "", "video_path": None, "robot_type": robot}


def info(
    like: Mapping[str, Any],
    features: Mapping[str, Feature],
    *,
    frames: int,
    episodes: int,
    tasks: int,
) -> dict[str, Any]:
    """meta/info.json of a dataset of `features`, else as another's, `like`."""
    listed = {name: {**of, "shape": list(of["shape"])} for name, of in features.items()}
    of_lerobot = {name: {**of, "shape": list(of["shape"])} for name, of in LEROBOT_COLUMNS.items()}
    videos = any(of["dtype"] == PICTURES[1] for of in features.values())
    return {
        **like,
        "features": {**listed, **of_lerobot},
        "total_frames": frames,
        "total_episodes": episodes,
        "total_tasks": tasks,
        "chunks_size": CHUNK,
        "splits": {"train": f"0:{episodes}"},
        "data_path": DATA_FILE,
        "video_path": VIDEO_FILE if videos else None,
    }


def episode_statistic(values: NDArray, *, picture: bool) -> pa.Array:
    """A column of meta/episodes with a statistic [E, D] of each episode: one type for all, as LeRobot
    keeps the minimum of a flag as a flag where each episode is a single row, and cannot merge that
    with numbers.
    """
    kind = pa.list_(pa.from_numpy_dtype(values.dtype))
    if picture:
        return to_arrow(values[..., None, None], pa.list_(pa.list_(kind)))
    return to_arrow(values, kind)
