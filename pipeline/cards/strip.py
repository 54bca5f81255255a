"""A strip of sample frames, small enough to lie in git beside a card."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data.schema import CAMERA, IMAGE_SHAPE

COUNT = 6  # frames in a strip
GAP = 2  # [pixels] of white between frames
QUALITY = 80  # of the JPEG: about 4 kB a frame


def sample_rows(frames: int, count: int = COUNT) -> list[int]:
    """The rows in the middle of `count` equal parts of `frames` rows; all where there are fewer."""
    count = min(count, frames)
    return [(2 * part + 1) * frames // (2 * count) for part in range(count)]


def read_some_images(path: Path, rows: Sequence[int]) -> list[NDArray[np.uint8]]:
    """The camera images uint8 [72, 160, 3] (RGB) in `rows`, which rise.

    Only their row groups are read, which are episodes: a rollout's images fill gigabytes.

    Raises:
        ValueError: an image is none of ours.
    """
    wanted = list(rows)
    images: list[NDArray[np.uint8]] = []
    first = 0
    for file, group, length in _row_groups(path):
        here = [row - first for row in wanted if first <= row < first + length]
        if here:
            png = file.read_row_group(group, columns=[CAMERA]).column(0).combine_chunks()
            images += [
                _decode(path, bytes_) for bytes_ in png.field("bytes").take(here).to_pylist()
            ]
        first += length
    return images


def strip(images: Sequence[NDArray[np.uint8]]) -> bytes:
    """Images [72, 160, 3] beside each other, as a JPEG; the same images give the same bytes."""
    gap = np.full((IMAGE_SHAPE[0], GAP, 3), 255, np.uint8)
    parts = [part for image in images for part in (gap, image)][1:]
    picture = cv2.cvtColor(np.concatenate(parts, axis=1), cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


def _row_groups(path: Path) -> Iterator[tuple[pq.ParquetFile, int, int]]:
    """Every file with each of its row groups and the rows in it, in order."""
    for data in sorted((path / "data").glob("*/*.parquet")):
        file = pq.ParquetFile(data)
        for group in range(file.num_row_groups):
            yield file, group, file.metadata.row_group(group).num_rows


def _decode(path: Path, png: bytes | None) -> NDArray[np.uint8]:
    pixels = np.frombuffer(png or b"", np.uint8)
    image = cv2.imdecode(pixels, cv2.IMREAD_COLOR_RGB) if len(pixels) else None
    if image is None or image.shape != IMAGE_SHAPE:
        raise ValueError(f"{path}: an image is no PNG of shape {IMAGE_SHAPE}")
    return image.astype(np.uint8, copy=False)
