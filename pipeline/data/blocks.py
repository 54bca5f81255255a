"""The files of a new dataset, in LeRobot's format v3.0, of rows as they are stored."""

import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data import layout, statistics
from pipeline.data.schema import LEROBOT_COLUMNS, PICTURES, SOURCE, Feature
from pipeline.data.statistics import Statistics
from pipeline.data.stored import to_numpy

Numbers = dict[str, NDArray]
"""Columns [N, *shape] by name."""

GROUP = 32
"""Rows that a row group has at least, unless it is the last: an episode each, as LeRobot has it,
would take longer than its rows where episodes are of a frame or two."""


@dataclass(frozen=True, eq=False)
class Block:
    """Successive episodes of a new dataset that share a data file."""

    rows: pa.Table
    """without LeRobot's own columns"""
    lengths: Sequence[int]
    """rows of each episode"""
    tasks: Sequence[str]
    """of each episode"""
    file: Path | None = None
    """that they are from"""


def write_blocks(
    root: Path,
    blocks: Iterable[Block],
    features: Mapping[str, Feature],
    like: Mapping[str, Any],
    *,
    seen: Mapping[str, Statistics | None],
    placed: Mapping[str, NDArray],
) -> None:
    """Write all of a dataset of `features` but safedagger.json into the new directory `root`: its data
    files, a block each, and meta/.

    Args:
        blocks: consumed one at a time; there may be none.
        like: a meta/info.json, to be like that in all that is not counted here.
        seen: by camera what is known of the pictures of the episodes, if anything.
        placed: columns of meta/episodes beyond those of the data files: where the videos are.
    """
    schema = layout.arrow_schema(features)
    (root / "meta").mkdir(parents=True)
    lengths: list[int] = []
    tasks: list[str] = []
    files: list[int] = []
    task_index: dict[str, int] = {}  # numbered as they appear
    numbers: list[Numbers] = []
    for number, block in enumerate(_at_least_one(blocks, features)):
        for task in block.tasks:
            task_index.setdefault(task, len(task_index))
        counted = _counted(block, len(lengths), sum(lengths), task_index, like["fps"])
        rows = block.rows
        for name, values in counted.items():
            rows = rows.append_column(name, pa.array(values))
        rows = rows.replace_schema_metadata(schema.metadata)
        file = root / layout.DATA_FILE.format(**layout.place(number))
        file.parent.mkdir(parents=True, exist_ok=True)
        _write_rows(file, rows, block)
        numbers.append(_numbers(block.rows, features) | counted)
        lengths += block.lengths
        tasks += block.tasks
        files += [number] * len(block.lengths)
    stops = np.cumsum(lengths, dtype=np.int64)
    about = {
        "episode_index": np.arange(len(lengths)),
        "tasks": pa.array([[task] for task in tasks], pa.list_(pa.string())),
        "length": pa.array(lengths, pa.int64()),
        "data/chunk_index": pa.array([file // layout.CHUNK for file in files], pa.int64()),
        "data/file_index": pa.array([file % layout.CHUNK for file in files], pa.int64()),
        "dataset_from_index": stops - lengths,
        "dataset_to_index": stops,
        **placed,
    }
    joined = {name: np.concatenate([part[name] for part in numbers]) for name in numbers[0]}
    _write_metadata(root, about, joined, seen, lengths)
    layout.write_tasks(root, list(task_index))
    counts = {"frames": sum(lengths), "episodes": len(lengths), "tasks": len(task_index)}
    layout.write_json(root / "meta" / "info.json", layout.info(like, features, **counts))


def _at_least_one(blocks: Iterable[Block], features: Mapping[str, Feature]) -> Iterator[Block]:
    """The blocks, or one without rows: a dataset without a file is none."""
    found = False
    for block in blocks:
        found = True
        yield block
    if not found:
        schema = layout.arrow_schema(features)
        yield Block(schema.empty_table().drop_columns(list(LEROBOT_COLUMNS)), [], [])


def _counted(
    block: Block, episode: int, row: int, task_index: Mapping[str, int], fps: int
) -> Numbers:
    """LeRobot's own columns [N] of a block that begins with this episode and row."""
    lengths = np.array(block.lengths, np.int64)
    firsts = np.cumsum(lengths) - lengths
    index = np.arange(lengths.sum())
    place = index - np.repeat(firsts, lengths)
    tasks = np.array([task_index[task] for task in block.tasks], np.int64)
    return {
        "timestamp": (place / fps).astype(np.float32),
        "frame_index": place,
        "episode_index": np.repeat(episode + np.arange(len(lengths)), lengths),
        "index": row + index,
        "task_index": np.repeat(tasks, lengths),
    }


def _write_rows(file: Path, rows: pa.Table, block: Block) -> None:
    groups = row_groups(block.lengths)
    if block.file is not None and _has_just(block.file, rows, groups):
        shutil.copyfile(block.file, file)
        return
    with pq.ParquetWriter(file, rows.schema, compression="snappy") as writer:
        start = 0
        for size in groups:
            writer.write_table(rows.slice(start, size))
            start += size


def row_groups(lengths: Sequence[int]) -> list[int]:
    """Rows of each row group: whole episodes."""
    groups: list[int] = []
    for length in lengths:
        if groups and groups[-1] < GROUP:
            groups[-1] += length
        else:
            groups.append(length)
    return groups


def _has_just(file: Path, rows: pa.Table, groups: Sequence[int]) -> bool:
    """Whether the file that `rows` are from has them all, in this order and in row groups of these
    sizes, and numbered as here.
    """
    numbered = [*LEROBOT_COLUMNS, *(name for name in SOURCE if name in rows.column_names)]
    with pq.ParquetFile(file) as there:
        sizes = [there.metadata.row_group(n).num_rows for n in range(there.num_row_groups)]
        return (
            sizes == list(groups)
            and there.schema_arrow.equals(rows.schema, check_metadata=True)
            and len(numbered) > len(LEROBOT_COLUMNS)
            and there.read(numbered).equals(rows.select(numbered))
        )


def _numbers(rows: pa.Table, features: Mapping[str, Feature]) -> Numbers:
    return {
        name: to_numpy(rows[name], of)
        for name, of in features.items()
        if of["dtype"] not in (*PICTURES, "string")
    }


def _write_metadata(
    root: Path,
    about: Mapping[str, Any],
    numbers: Numbers,
    seen: Mapping[str, Statistics | None],
    lengths: Sequence[int],
) -> None:
    """meta/episodes, with the columns `about`, and meta/stats.json."""
    each = statistics.of_columns(numbers, lengths)
    overall = statistics.of_columns(numbers, [sum(lengths)] if lengths else [])
    if lengths:
        each = {n: statistics.with_placeholders(of, overall[n]) for n, of in each.items()}
        for camera, of in seen.items():
            if of is not None:
                each[camera], overall[camera] = of, statistics.aggregate(of)
    table, known = dict(about), {}
    for name, of in each.items():
        for key in statistics.NAMES:
            nested = name in seen and key != "count"
            table[f"stats/{name}/{key}"] = layout.episode_statistic(of[key], picture=nested)
        if overall[name]["count"].any():
            known[name] = {
                key: values[0, :, None, None] if name in seen and key != "count" else values[0]
                for key, values in overall[name].items()
            }
    for name in ("meta/episodes/chunk_index", "meta/episodes/file_index"):
        table[name] = np.zeros(len(lengths), np.int64)
    layout.write_statistics(root, known)
    file = root / layout.EPISODES_FILE
    file.parent.mkdir(parents=True)
    pq.write_table(pa.table(table), file, compression="snappy")
