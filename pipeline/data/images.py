"""What the cameras of a dataset saw: PNG files in its rows, or videos beside them.

In the shapes, N is the number of rows, and H, W, C are the camera's height, width and channels.
"""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Episode
from pipeline.data.stored import pngs, to_numpy

Images = NDArray[np.uint8]

KEPT = 2 * 2**30
"""[bytes] of decoded images that stay in memory: 60,000 of the car's."""


class StoredImages:
    """Stands for an array of images uint8 [N, H, W, C] (RGB) that may not fit into memory: it is
    asked for rows as an array is, and decodes them then: ValueError for an image that is none of its
    shape. The first, as many as fit into `KEPT`, are decoded once.
    """

    dtype = np.dtype(np.uint8)

    def __init__(self, where: str, files: list[bytes], shape: tuple[int, ...]) -> None:
        self.shape = (len(files), *shape)
        self._rows = np.arange(len(files))
        self._files, self._decode = files, partial(_decode, where, shape)
        kept = min(len(files), KEPT // math.prod(shape))
        self._kept = np.empty((kept, *shape), np.uint8)  # no memory until it is written to
        self._is_decoded = np.zeros(kept, bool)
        self._pool = ThreadPoolExecutor(2)  # OpenCV decodes outside the GIL

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, rows: slice | NDArray[np.integer]) -> Images:
        numbers = self._rows[rows]
        stay = numbers < len(self._kept)
        new = np.unique(numbers[stay])
        new = new[~self._is_decoded[new]]
        for row, image in zip(new, self._decoded(new), strict=True):
            self._kept[row] = image
            self._files[row] = b""
        self._is_decoded[new] = True
        if stay.all():
            return self._kept[numbers]
        images = np.empty((len(numbers), *self.shape[1:]), np.uint8)
        images[stay] = self._kept[numbers[stay]]
        for place, image in zip(np.flatnonzero(~stay), self._decoded(numbers[~stay]), strict=True):
            images[place] = image
        return images

    def _decoded(self, rows: NDArray[np.integer]) -> Iterator[Images]:
        return self._pool.map(self._decode, [self._files[row] for row in rows])


def read_images(
    dataset: Dataset, camera: str, rows: Sequence[tuple[int, int]] | None = None
) -> Images | StoredImages:
    """Images of a camera, uint8 [N, H, W, C] (RGB); those that are no videos are decoded when they
    are asked for. Of all rows, or from each (start, stop) of `rows`, as `Dataset.tables` takes them.
    ValueError where there is no such camera.
    """
    shape = _shape(dataset, camera)
    rows = dataset.bounds if rows is None else rows
    if dataset.features[camera]["dtype"] == "video":
        images = np.empty((sum(stop - start for start, stop in rows), *shape), np.uint8)
        filled = 0
        for part in read_pictures(dataset, camera, rows):
            images[filled : filled + len(part)] = part
            filled += len(part)
        return images
    files = [png for table in dataset.tables(rows, [camera]) for png in pngs(table[camera])]
    return StoredImages(f"{dataset.path}: {camera}", files, shape)


def read_all(
    dataset: Dataset, names: Iterable[str], rows: Sequence[tuple[int, int]] | None = None
) -> dict[str, Any]:
    """Some columns, pictures among them: arrays [N, *shape] by name, or `StoredImages`; of all rows,
    or as `read_images`. ValueError where there is no such column.
    """
    names = list(names)
    numbers = dataset.columns(name for name in names if name not in dataset.cameras)
    kept = slice(None) if rows is None else np.concatenate([np.arange(*each) for each in rows])
    return {
        name: numbers[name][kept] if name in numbers else read_images(dataset, name, rows)
        for name in names
    }


def read_some_images(dataset: Dataset, camera: str, rows: Sequence[int]) -> list[Images]:
    """The images uint8 [H, W, C] (RGB) of a camera in `rows`, which rise; no others are read. ValueError
    where there is no such camera.
    """
    return [part[0] for part in read_pictures(dataset, camera, [(row, row + 1) for row in rows])]


def read_episodes(
    dataset: Dataset, only: Iterable[int] | None = None
) -> Iterator[tuple[int, Episode]]:
    """The episodes with their numbers, or `only` some, in order; one at a time is in memory, and no
    others are read.

    Core columns that the dataset lacks are derived, as `Dataset.columns` does.
    """
    chosen = range(len(dataset.lengths)) if only is None else sorted(only)
    bounds = [dataset.bounds[episode] for episode in chosen]
    features = dataset.with_core
    cameras = dataset.cameras
    numbers = [name for name in features if name not in cameras]
    stored = [name for name in numbers if dataset.has(name)]
    derived = dataset.columns([name for name in numbers if not dataset.has(name)])
    streams = [read_pictures(dataset, camera, bounds) for camera in cameras]
    tables = dataset.tables(bounds, stored)
    for episode, (start, stop), table, *seen in zip(chosen, bounds, tables, *streams, strict=True):
        columns = {name: to_numpy(table[name], features[name]) for name in stored}
        columns |= {name: values[start:stop] for name, values in derived.items()}
        columns |= dict(zip(cameras, seen, strict=True))
        yield episode, Episode(dataset.tasks[episode], columns, features)


def _shape(dataset: Dataset, camera: str) -> tuple[int, ...]:
    if camera not in dataset.cameras:
        known = ", ".join(dataset.cameras) or "none"
        raise ValueError(f"{dataset.path}: has no camera {camera!r}, expected one of {known}")
    return tuple(dataset.features[camera]["shape"])


def read_pictures(
    dataset: Dataset, camera: str, rows: Sequence[tuple[int, int]]
) -> Iterator[Images]:
    """uint8 [stop - start, H, W, C] for each (start, stop) of `rows`, as `Dataset.tables` takes them."""
    shape = _shape(dataset, camera)
    if dataset.features[camera]["dtype"] == "video":
        yield from _from_videos(dataset, camera, rows)
        return
    # OpenCV decodes outside the GIL
    with ThreadPoolExecutor(2) as pool:
        for table in dataset.tables(rows, [camera]):
            png = pngs(table[camera])
            decoded = pool.map(partial(_decode, f"{dataset.path}: {camera}", shape), png)
            yield np.stack(list(decoded))


def _decode(where: str, shape: tuple[int, ...], png: bytes) -> Images:
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR_RGB) if png else None
    if image is None or image.shape != shape:
        raise ValueError(f"{where}: an image is no PNG of shape {shape}")
    return image.astype(np.uint8, copy=False)


def _from_videos(
    dataset: Dataset, camera: str, rows: Sequence[tuple[int, int]]
) -> Iterator[Images]:
    from lerobot.datasets.video_utils import decode_video_frames

    starts = [start for start, _ in dataset.bounds]
    for start, stop in rows:
        episode = bisect_right(starts, start) - 1
        file, begin = dataset.video_of(camera, episode)
        times = begin + (np.arange(start, stop) - starts[episode]) / dataset.fps
        frames = decode_video_frames(file, times.tolist(), 1e-4, "pyav", return_uint8=True)
        yield frames.permute(0, 2, 3, 1).numpy()
