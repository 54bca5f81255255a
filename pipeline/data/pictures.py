"""What becomes of pictures where pieces of datasets are put together: their statistics, and videos."""

import shutil
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data import layout
from pipeline.data.dataset import Dataset
from pipeline.data.pieces import Piece
from pipeline.data.statistics import NAMES, Statistics, joined
from pipeline.data.stored import flat


def known_statistics(pieces: Sequence[Piece], camera: str) -> Statistics | None:
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


def pass_videos(root: Path, pieces: Sequence[Piece], camera: str) -> dict[str, NDArray]:
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
        copy = root / layout.VIDEO_FILE.format(camera=camera, **layout.place(number))
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
