"""Datasets made of pieces of others: what is stored passes through as it is, no picture is encoded
or decoded, and equal pieces give equal bytes.

LeRobot has no tool that keeps some frames of an episode, and what it writes depends on more than
the content: on PYTHONHASHSEED, and on absolute paths. So the files are written here, in its format
v3.0, as its loader and its tools read them.
"""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data import layout
from pipeline.data.blocks import Block, write_blocks
from pipeline.data.content import ContentHash
from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.pieces import Piece, stored_rows
from pipeline.data.schema import Feature, pictures
from pipeline.data.statistics import NAMES, Statistics, joined
from pipeline.data.stored import flat


def assemble(
    root: Path,
    pieces: Sequence[Piece],
    recipe: Recipe,
    *,
    like: Dataset,
    features: Mapping[str, Feature],
) -> None:
    """Write `pieces`, in that order, as a dataset of `features` in the new directory `root`, with the frame
    rate and the robot of another, `like`; `recipe` is how it was made. There may be none; of what a
    piece lacks see `stored_rows`.

    One file for each file of the pieces: those of D_{i-1} are taken as they are, so that DVC stores
    them once.
    """
    content = ContentHash(recipe, features, fps=like.fps, robot=like.info["robot_type"])

    def blocks() -> Iterator[Block]:
        for group, rows in stored_rows(pieces, features):
            lengths, tasks = [len(piece) for piece in group], [piece.task for piece in group]
            content.add(rows, lengths, tasks)
            source = group[0].dataset
            yield Block(rows, lengths, tasks, source.data_files[source.file_of(group[0].start)])

    videos = [name for name in pictures(features) if features[name]["dtype"] == "video"]
    write_blocks(
        root,
        blocks(),
        features,
        like.info,
        seen={camera: _known_statistics(pieces, camera) for camera in pictures(features)},
        placed={k: v for camera in videos for k, v in _pass_videos(root, pieces, camera).items()},
    )
    for camera in videos:
        places = [piece.dataset.video_of(camera, piece.episode) for piece in pieces]
        files = list(dict.fromkeys(file for file, _ in places))
        content.add_videos([begin for _, begin in places], files)
    content.lineage().write(root)


def _known_statistics(pieces: Sequence[Piece], camera: str) -> Statistics | None:
    """Of each piece, those of its episode, as LeRobot's tools have it: nothing is decoded. None where
    nobody has written any down.
    """
    found = []
    for dataset, group in groupby(pieces, lambda piece: piece.dataset):
        of_episodes = _written(dataset, camera)
        if of_episodes is None:
            return None
        here = list(group)
        episodes = [piece.episode for piece in here]
        counts = np.array([[len(piece)] for piece in here])
        found.append({n: of[episodes] for n, of in of_episodes.items()} | {"count": counts})
    return joined(found) if found else None


def _written(dataset: Dataset, camera: str) -> Statistics | None:
    """Those that meta/episodes has, of each episode; None unless it has them all."""
    columns = {name: f"stats/{camera}/{name}" for name in NAMES}
    files = [pq.ParquetFile(file) for file in dataset.episode_files]
    if not all(set(columns.values()) <= set(file.schema_arrow.names) for file in files):
        return None
    table = pa.concat_tables(file.read(list(columns.values())) for file in files)
    # LeRobot's tools flatten what they have read: [C, 1, 1] becomes [C]
    return {
        name: flat(table[column].combine_chunks()).to_numpy().reshape(len(table), -1)
        for name, column in columns.items()
    }


def _pass_videos(root: Path, pieces: Sequence[Piece], camera: str) -> dict[str, NDArray]:
    """Copy the videos that the pieces are in, and say where each piece is: columns of meta/episodes.

    A video is copied as it is, with all its frames: cutting one would encode it anew.
    """
    begins, numbers = [], []
    files: dict[Path, int] = {}
    for piece in pieces:
        file, begin = piece.dataset.video_of(camera, piece.episode)
        numbers.append(files.setdefault(file, len(files)))
        first = piece.dataset.bounds[piece.episode][0]
        begins.append(begin + (piece.start - first) / piece.dataset.fps)
    for file, number in files.items():
        copy = root / layout.VIDEO_FILE.format(video_key=camera, **layout.place(number))
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
    placed, starts = np.array(numbers, np.int64), np.array(begins, float)
    lasts = [len(piece) / piece.dataset.fps for piece in pieces]
    return {
        f"videos/{camera}/chunk_index": placed // layout.CHUNK,
        f"videos/{camera}/file_index": placed % layout.CHUNK,
        f"videos/{camera}/from_timestamp": starts,
        f"videos/{camera}/to_timestamp": starts + np.array(lasts, float),
    }
