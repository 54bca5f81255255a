"""Datasets made of pieces of others: what is stored passes through as it is, no picture is encoded
anew, and equal pieces give equal bytes.

LeRobot has no tool that keeps some frames of an episode, and what it writes depends on more than
the content: on PYTHONHASHSEED, and on absolute paths. So the files are written here, in its format
v3.0, as its loader and its tools read them.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data import layout, statistics
from pipeline.data.dataset import Dataset
from pipeline.data.images import pngs, video_of
from pipeline.data.lineage import Recipe, first_bits
from pipeline.data.pictures import image_statistics, pass_videos
from pipeline.data.pieces import Piece, stored_rows, to_arrow
from pipeline.data.schema import LEROBOT_COLUMNS, OWN, Feature, pictures
from pipeline.data.statistics import NAMES, Statistics
from pipeline.data.stored import to_numpy

Numbers = dict[str, NDArray]
"""The columns of a piece that are numbers."""


def assemble(
    root: Path,
    pieces: Sequence[Piece],
    recipe: Recipe,
    *,
    like: Dataset,
    features: Mapping[str, Feature],
) -> None:
    """Write `pieces`, in that order, as a dataset of `features`; there may be none.

    Args:
        root: a new directory; its parent is there.
        pieces: of datasets with some of `features`; of what one lacks see `stored_rows`.
        recipe: what the new dataset is and comes from.
        like: whose frame rate and robot it has.
        features: its columns.
    """
    sha256 = content_hash(pieces, features, recipe, like)
    tasks = list(dict.fromkeys(piece.task for piece in pieces))
    (root / "meta").mkdir(parents=True)
    files, numbers = _write_rows(root, pieces, features, tasks, like.fps, first_bits(sha256))
    stops = np.cumsum([len(piece) for piece in pieces], dtype=np.int64)
    placed = {
        "episode_index": list(range(len(pieces))),
        "tasks": [[piece.task] for piece in pieces],
        "length": [len(piece) for piece in pieces],
        "data/chunk_index": [file // layout.CHUNK for file in files],
        "data/file_index": [file % layout.CHUNK for file in files],
        "dataset_from_index": [0, *stops.tolist()][: len(pieces)],
        "dataset_to_index": stops.tolist(),
    }
    for camera in pictures(features):
        if features[camera]["dtype"] == "video":
            placed |= pass_videos(root, pieces, camera)
    _write_metadata(root, placed, pieces, features, numbers)
    layout.write_tasks(root, tasks)
    about = layout.info(
        like.info,
        features,
        frames=sum(map(len, pieces)),
        episodes=len(pieces),
        tasks=len(tasks),
    )
    layout.write_json(root / "meta" / "info.json", about)
    recipe.lineage(sha256).write(root)


def content_hash(
    pieces: Sequence[Piece], features: Mapping[str, Feature], recipe: Recipe, like: Dataset
) -> str:
    """SHA-256 in hexadecimal of what a dataset of `pieces` holds, and of how it was made: as with
    the commits of git, the same content made of other parents is something else.

    The id that comes of it is no part of it: `OWN` stands for that in `source.dataset`.
    """
    listed = {name: [of["dtype"], *of["shape"]] for name, of in features.items()}
    made = [recipe.purpose, recipe.arguments, [parent.sha256 for parent in recipe.parents]]
    digest = hashlib.sha256(
        json.dumps([like.fps, like.info["robot_type"], listed, made], sort_keys=True).encode()
    )
    cameras = pictures(features)
    for piece, rows in stored_rows(pieces, features):
        digest.update(json.dumps([piece.task, len(piece)]).encode())
        for name in rows.column_names:
            if name in cameras:
                for png in pngs(rows[name]):
                    digest.update(len(png).to_bytes(8, "little") + png)
            elif features[name]["dtype"] == "string":
                digest.update(json.dumps(rows[name].to_pylist()).encode())
            else:
                digest.update(to_numpy(rows[name], features[name]).tobytes())
    for camera in (name for name in cameras if features[name]["dtype"] == "video"):
        places = [video_of(piece.dataset, camera, piece.episode) for piece in pieces]
        digest.update(json.dumps([begin for _, begin in places]).encode())
        for file in dict.fromkeys(file for file, _ in places):
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _write_rows(
    root: Path,
    pieces: Sequence[Piece],
    features: Mapping[str, Feature],
    tasks: Sequence[str],
    fps: int,
    own_id: int,
) -> tuple[list[int], list[Numbers]]:
    """The number of the file that each piece is in, and its columns of numbers.

    One file for each file of the pieces: those of D_{i-1} stay byte for byte what they were, so
    that DVC stores them once. A row group an episode, as LeRobot has it.
    """
    schema = layout.arrow_schema(features)
    files: list[int] = []
    numbers: list[Numbers] = []
    row = 0
    groups = groupby(pieces, lambda piece: (piece.dataset, piece.dataset.file_of(piece.start)))
    for number, group in enumerate([list(group) for _, group in groups] or [[]]):
        file = root / layout.DATA_FILE.format(**layout.place(number))
        file.parent.mkdir(parents=True, exist_ok=True)
        with pq.ParquetWriter(file, schema, compression="snappy") as writer:
            for piece, rows in stored_rows(group, features):
                rows = _named(rows, own_id)
                counted = _counted(len(piece), len(files), row, tasks.index(piece.task), fps)
                for name, values in counted.items():
                    rows = rows.append_column(name, to_arrow(values, schema.field(name).type))
                writer.write_table(rows.replace_schema_metadata(schema.metadata))
                numbers.append(_numbers(rows, features))
                files.append(number)
                row += len(piece)
    return files, numbers


def _named(rows: pa.Table, own_id: int) -> pa.Table:
    """With the dataset's own id in `source.dataset` where it was not known yet."""
    if "source.dataset" not in rows.column_names:
        return rows
    source = rows["source.dataset"].to_numpy()
    column = pa.array(np.where(source == OWN, own_id, source))
    return rows.set_column(rows.column_names.index("source.dataset"), "source.dataset", column)


def _counted(length: int, episode: int, row: int, task: int, fps: int) -> Numbers:
    """LeRobot's own columns."""
    place = np.arange(length, dtype=np.int64)
    return {
        "timestamp": (place / fps).astype(np.float32),
        "frame_index": place,
        "episode_index": np.full(length, episode, np.int64),
        "index": row + place,
        "task_index": np.full(length, task, np.int64),
    }


def _numbers(rows: pa.Table, features: Mapping[str, Feature]) -> Numbers:
    return {
        name: to_numpy(rows[name], of)
        for name, of in {**features, **LEROBOT_COLUMNS}.items()
        if of["dtype"] not in ("image", "video", "string")
    }


def _write_metadata(
    root: Path,
    placed: Mapping[str, list],
    pieces: Sequence[Piece],
    features: Mapping[str, Feature],
    numbers: Sequence[Numbers],
) -> None:
    """meta/episodes and meta/stats.json."""
    joined = {name: np.concatenate([n[name] for n in numbers]) for name in (numbers or [{}])[0]}
    overall = statistics.of_columns(joined)
    each = [statistics.of_columns(columns) for columns in numbers]
    of_episodes: dict[str, list[Statistics]] = {
        name: [
            of[name] or statistics.placeholder(overall[name], joined[name][0].size) for of in each
        ]
        for name in joined
    }
    for camera in pictures(features) if pieces else ():
        seen = image_statistics(pieces, camera)
        if seen is not None:
            of_episodes[camera], overall[camera] = seen, statistics.aggregate(seen)
    known = {name: of for name, of in overall.items() if of is not None}
    layout.write_json(root / "meta" / "stats.json", known, sort_keys=True)
    table = {name: layout.episode_column(name, values) for name, values in placed.items()}
    for name, parts in of_episodes.items():
        for statistic in NAMES:
            key = f"stats/{name}/{statistic}"
            table[key] = layout.episode_column(key, [part[statistic] for part in parts])
    for name in ("meta/episodes/chunk_index", "meta/episodes/file_index"):
        table[name] = layout.episode_column(name, [0] * len(pieces))
    layout.write_table(root / layout.EPISODES_FILE, pa.table(table))
