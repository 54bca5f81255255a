"""Reading datasets: checks with one-line errors, columns, images, episodes.

LeRobot's loader creates a mistyped path and then asks the network for it, copies the data into a
cache, and takes 15 s to import. So the columns are read from the parquet files themselves, after
`check_dataset` has made sure that LeRobot could load them. In the shapes, N is the number of rows.
"""

import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.data.schema import (
    CAMERA,
    COLUMNS,
    CONTROL_HZ,
    FEATURES,
    IMAGE_SHAPE,
    LEROBOT_COLUMNS,
    ROBOT_TYPE,
    Episode,
)

_FORMAT = "v3.0"
_IMAGES_AT_ONCE = 256


def check_dataset(path: Path) -> int:
    """Check that `path` is a complete dataset of our schema; cheap: no rows are read.

    Returns:
        record_every, the control frames that a row stands for: 30 / fps.

    Raises:
        FileNotFoundError: there is nothing at `path`.
        ValueError: it is no dataset, half-written, or of another schema, format or frame rate.
    """
    info = _read_info(path)
    _check_schema(path, info)
    _check_complete(path, info)
    return CONTROL_HZ // info["fps"]


def read_columns(path: Path, names: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """All rows of the columns `names`, by default of all but the images.

    Returns:
        [N, *shape] of each column's own dtype, and "episode_index" and "frame_index", int64 [N].

    Raises:
        ValueError: a name is none of `COLUMNS`; or as `check_dataset`.
        FileNotFoundError: as `check_dataset`.
    """
    wanted = COLUMNS if names is None else tuple(names)
    for name in wanted:
        if name not in COLUMNS:
            raise ValueError(f"no column is named {name!r}, expected some of {', '.join(COLUMNS)}")
    check_dataset(path)
    columns = read_numbers(path, [*wanted, "episode_index", "frame_index"])
    for name in ("episode_index", "frame_index"):
        columns[name] = columns[name][:, 0]
    return columns


def read_images(path: Path) -> np.ndarray:
    """All camera images, uint8 [N, 72, 160, 3] (RGB), rows in order: 35 kB of memory for each.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`; or an image that is none of ours.
    """
    check_dataset(path)
    rows = sum(pq.read_metadata(file).num_rows for file in _data_files(path))
    images = np.empty((rows, *IMAGE_SHAPE), np.uint8)
    for row, image in enumerate(_decoded_images(path)):
        images[row] = image
    return images


def read_some_images(path: Path, rows: Sequence[int]) -> list[np.ndarray]:
    """The camera images uint8 [72, 160, 3] (RGB) in `rows`, which rise.

    Only their row groups are read, which are episodes: a rollout's images fill gigabytes.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`; or an image that is none of ours.
    """
    check_dataset(path)
    images: list[np.ndarray] = []
    first = 0
    for file in _data_files(path):
        parquet = pq.ParquetFile(file)
        for group in range(parquet.num_row_groups):
            length = parquet.metadata.row_group(group).num_rows
            here = [row - first for row in rows if first <= row < first + length]
            if here:
                images_here = parquet.read_row_group(group, columns=[CAMERA]).column(0)
                png = images_here.combine_chunks().field("bytes").take(here).to_pylist()
                images += [_decode(file, each) for each in png]
            first += length
    return images


def read_episodes(path: Path) -> Iterator[Episode]:
    """The episodes in order, one at a time, so that only one is in memory with its images.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`, at once.
    """
    check_dataset(path)
    columns = read_numbers(path, COLUMNS)
    index = read_numbers(path, ["episode_index", "task_index"])
    tasks = pq.read_table(path / "meta" / "tasks.parquet").to_pydict()
    task_names = dict(zip(tasks["task_index"], tasks["task"], strict=True))
    episode_index, task_index = index["episode_index"][:, 0], index["task_index"][:, 0]
    starts = np.flatnonzero(np.diff(episode_index, prepend=-1))
    images = _decoded_images(path)

    def episode(start: int, stop: int) -> Episode:
        rows = {name: column[start:stop] for name, column in columns.items()}
        camera = np.stack(list(islice(images, stop - start)))
        return Episode(task_names[int(task_index[start])], {CAMERA: camera, **rows})

    stops = np.append(starts[1:], len(episode_index))
    return (episode(int(a), int(b)) for a, b in zip(starts, stops, strict=True))


def read_numbers(path: Path, names: Sequence[str]) -> dict[str, np.ndarray]:
    """All rows of any columns but the images, LeRobot's own too: [N, *shape]. Checks nothing."""
    parts = [pq.ParquetFile(file).read(columns=list(names)) for file in _data_files(path)]
    columns = {}
    for name in names:
        feature = FEATURES.get(name) or {"dtype": LEROBOT_COLUMNS[name], "shape": (1,)}
        chunks = [chunk for part in parts for chunk in part[name].chunks]
        # a vector may be a list or a list of fixed size: flat they are the same
        flat = [chunk if feature["shape"] == (1,) else chunk.flatten() for chunk in chunks]
        values = np.concatenate([values.to_numpy(zero_copy_only=False) for values in flat])
        columns[name] = values.astype(feature["dtype"], copy=False).reshape(-1, *feature["shape"])
    return columns


def _read_info(path: Path) -> dict[str, Any]:
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such dataset")
    info_path = path / "meta" / "info.json"
    if not info_path.is_file():
        raise ValueError(f"{path}: not a dataset, expected a directory with meta/info.json")
    try:
        info = json.loads(info_path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: meta/info.json is not JSON ({error})") from error
    needed = ("codebase_version", "robot_type", "fps", "features", "total_frames", "total_episodes")
    for key in needed:
        if key not in info:
            raise ValueError(f"{path}: not a LeRobot dataset, meta/info.json has no {key!r}")
    return info


def _check_schema(path: Path, info: dict[str, Any]) -> None:
    if info["codebase_version"] != _FORMAT:
        raise ValueError(f"{path}: LeRobot format {info['codebase_version']}, expected {_FORMAT}")
    found = info["features"]
    for name, feature in FEATURES.items():
        if name not in found:
            raise ValueError(f"{path}: another schema, column {name!r} is missing")
        for part, expected in {**feature, "shape": list(feature["shape"])}.items():
            if found[name].get(part) != expected:
                raise ValueError(
                    f"{path}: another schema, {part} of column {name!r} is "
                    f"{found[name].get(part)}, expected {expected}"
                )
    for name in found:
        if name not in FEATURES and name not in LEROBOT_COLUMNS:
            raise ValueError(f"{path}: another schema, column {name!r} is none of ours")
    if info["robot_type"] != ROBOT_TYPE:
        raise ValueError(f"{path}: robot_type is {info['robot_type']!r}, expected {ROBOT_TYPE!r}")
    if not isinstance(info["fps"], int) or info["fps"] < 1 or CONTROL_HZ % info["fps"]:
        raise ValueError(f"{path}: fps is {info['fps']}, expected a divisor of {CONTROL_HZ}")


def _check_complete(path: Path, info: dict[str, Any]) -> None:
    """LeRobot writes info.json first and the parquet footers last: whatever disagrees was cut."""
    episode_files = sorted((path / "meta" / "episodes").glob("*/*.parquet"))
    files = {"data": _data_files(path), "meta/episodes": episode_files}
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
    for file in files["data"]:
        names = pq.read_schema(file).names
        for name in (*FEATURES, *LEROBOT_COLUMNS):
            if name not in names:
                part = file.relative_to(path)
                raise ValueError(f"{path}: another schema, {part} has no column {name!r}")


def _rows_in_footer(path: Path, file: Path) -> int:
    try:
        return pq.read_metadata(file).num_rows
    except (pa.ArrowException, OSError) as error:
        part = file.relative_to(path)
        raise ValueError(f"{path}: half-written, {part} is missing or has no footer") from error


def _data_files(path: Path) -> list[Path]:
    return sorted((path / "data").glob("*/*.parquet"))


def _decoded_images(path: Path) -> Iterator[np.ndarray]:
    """uint8 [72, 160, 3] (RGB) for each row. Two threads: OpenCV decodes outside the GIL."""
    with ThreadPoolExecutor(2) as pool:
        for file in _data_files(path):
            batches = pq.ParquetFile(file).iter_batches(_IMAGES_AT_ONCE, columns=[CAMERA])
            for batch in batches:
                png = batch.column(0).field("bytes").to_pylist()
                yield from pool.map(partial(_decode, file), png)


def _decode(file: Path, png: bytes) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR_RGB) if png else None
    if image is None or image.shape != IMAGE_SHAPE:
        raise ValueError(f"{file}: an image is no PNG of shape {IMAGE_SHAPE}")
    return image
