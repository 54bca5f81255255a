"""What becomes of pictures where pieces of datasets are put together: their statistics, and videos."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.data import layout
from pipeline.data.dataset import Dataset
from pipeline.data.images import read_pictures, video_of
from pipeline.data.pieces import Piece
from pipeline.data.statistics import NAMES, Statistics, of_images


def image_statistics(pieces: Sequence[Piece], camera: str) -> list[Statistics] | None:
    """Of each piece; None where a camera has videos of which nobody knows any.

    A whole episode keeps those that it has, and so does a part of a video, which is not decoded.
    """
    known = {dataset: _known(dataset, camera) for dataset in {piece.dataset for piece in pieces}}
    found = []
    for piece in pieces:
        of_episodes = known[piece.dataset]
        video = piece.dataset.features[camera]["dtype"] == "video"
        if of_episodes is not None and (piece.is_whole or video):
            found.append({**of_episodes[piece.episode], "count": [len(piece)]})
        elif video:
            return None
        else:
            (images,) = read_pictures(piece.dataset, camera, [(piece.start, piece.stop)])
            found.append(of_images(list(images)))
    return found


def _known(dataset: Dataset, camera: str) -> list[Statistics] | None:
    """Those that meta/episodes has, of each episode; None unless it has them all."""
    columns = {name: f"stats/{camera}/{name}" for name in NAMES}
    files = dataset.episode_files
    if not all(set(columns.values()) <= set(pq.read_schema(file).names) for file in files):
        return None
    table = pa.concat_tables(pq.ParquetFile(file).read(list(columns.values())) for file in files)
    rows = table.to_pydict()
    return [
        {
            # LeRobot's tools flatten what they have read: [C, 1, 1] becomes [C]
            name: np.reshape(value, (-1, 1, 1) if name != "count" else -1).tolist()
            for name, value in zip(columns, values, strict=True)
        }
        for values in zip(*(rows[key] for key in columns.values()), strict=True)
    ]


def pass_videos(root: Path, pieces: Sequence[Piece], camera: str) -> dict[str, list[Any]]:
    """Copy the videos that the pieces are in, and say where each piece is: columns of meta/episodes.

    A video is copied as it is, with all its frames: cutting one would encode it anew.
    """
    begins, numbers = [], []
    files: dict[Path, int] = {}
    for piece in pieces:
        file, begin = video_of(piece.dataset, camera, piece.episode)
        numbers.append(files.setdefault(file, len(files)))
        first = piece.dataset.bounds[piece.episode][0]
        begins.append(begin + (piece.start - first) / piece.dataset.fps)
    for file, number in files.items():
        copy = root / layout.VIDEO_FILE.format(camera=camera, **layout.place(number))
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
    fps = pieces[0].dataset.fps if pieces else 1
    return {
        f"videos/{camera}/chunk_index": [number // layout.CHUNK for number in numbers],
        f"videos/{camera}/file_index": [number % layout.CHUNK for number in numbers],
        f"videos/{camera}/from_timestamp": begins,
        f"videos/{camera}/to_timestamp": [
            begin + len(piece) / fps for begin, piece in zip(begins, pieces, strict=True)
        ],
    }
