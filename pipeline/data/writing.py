"""Recording datasets as LeRobot's writer does: complete or not at all; equal episodes give equal bytes.

LeRobot itself would encode each picture into a file of its own, decode it for the statistics, and
write rows that have to be written again: with the dataset's id, and without what differs by process.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pyarrow as pa
from numpy.typing import NDArray

from pipeline.data import layout
from pipeline.data.blocks import Block, write_blocks
from pipeline.data.content import ContentHash
from pipeline.data.dataset import DRIVES, Dataset
from pipeline.data.lineage import Lineage, Recipe
from pipeline.data.schema import OWN, Episode, Feature, pictures
from pipeline.data.statistics import Statistics, joined, of_images
from pipeline.output import new_directory


@dataclass(frozen=True)
class Summary:
    """What a dataset holds."""

    path: Path
    episodes: int
    frames: int
    """Rows."""
    queries: int
    """Frames for which the reference was asked."""

    @classmethod
    def of(cls, dataset: Dataset) -> "Summary":
        """Count it, from its columns."""
        queries = int(dataset.column("queried").sum())
        return cls(dataset.path, len(dataset.lengths), len(dataset), queries)

    def __str__(self) -> str:
        counts = f"{self.episodes} episodes, {self.frames} frames, {self.queries} queries"
        return f"{self.path}: {counts}"


def write_dataset(
    path: Path, episodes: Iterable[Episode], recipe: Recipe, *, fps: int, robot: str
) -> Summary:
    """Write `episodes`, consumed one at a time, as a LeRobot dataset of `fps` frames per second, of
    `robot` (LeRobot's `robot_type`), and beside it how their drives ended; `recipe` is how they
    were made.

    FileExistsError where `path` exists, before the first episode is asked for; ValueError where there
    are no episodes, where they differ in their columns, or where LeRobot could not read them.
    """
    with new_directory(path) as root:
        spool = root.parent / ".rows"
        recorded = _record(spool, episodes, recipe, fps, robot)
        write_blocks(
            root,
            _blocks(spool, recorded),
            recorded.features,
            layout.new_info(fps, robot),
            seen={camera: joined(parts) for camera, parts in recorded.seen.items()},
            placed={},
        )
        recorded.lineage.write(root)
        _write_endings(root / DRIVES, recorded.endings)
    return Summary.of(Dataset.open(path))


@dataclass(frozen=True)
class _Recorded:
    """What is known of episodes whose rows are in a file of Arrow's, a batch each: every row carries
    an id that comes of the content of all.
    """

    features: Mapping[str, Feature]
    lineage: Lineage
    tasks: list[str]
    seen: Mapping[str, list[Statistics]]
    """by camera, of each episode"""
    endings: list[Mapping[str, Any]]


def _record(
    spool: Path, episodes: Iterable[Episode], recipe: Recipe, fps: int, robot: str
) -> _Recorded:
    coming = iter(episodes)
    first = next(coming, None)
    if first is None:
        raise ValueError("there are no episodes, expected at least one frame")
    features = first.features
    _check(features, fps)
    schema = pa.schema([each for each in layout.arrow_schema(features) if each.name in features])
    content = ContentHash(recipe, features, fps=fps, robot=robot)
    seen: dict[str, list[Statistics]] = {camera: [] for camera in pictures(features)}
    tasks, endings = [], []
    # PNG is compressed outside the GIL
    with ThreadPoolExecutor(2) as pool, pa.ipc.new_file(str(spool), schema) as file:
        for episode in chain([first], coming):
            if episode.features != features:
                raise ValueError("the episodes differ in their columns, expected the same in all")
            columns = episode.columns
            stored = [
                _encoded(columns[name], kind, pool)
                if name in seen
                else layout.to_arrow(columns[name], kind)
                for name, kind in zip(schema.names, schema.types, strict=True)
            ]
            rows = pa.Table.from_arrays(stored, schema=schema)
            content.add(rows, [len(rows)], [episode.task])
            file.write_table(rows)
            for camera, of in seen.items():
                of.append(of_images(columns[camera]))
            tasks.append(episode.task)
            if episode.ending is not None:
                endings.append(episode.ending)
    return _Recorded(features, content.lineage(), tasks, seen, endings)


def _check(features: Mapping[str, Feature], fps: int) -> None:
    """Raise a ValueError for what LeRobot cannot read, or not as images."""
    if fps < 1:
        raise ValueError(f"fps is {fps}, expected at least 1")
    for name, of in features.items():
        if "/" in name:
            raise ValueError(f"column {name!r}: expected a name without '/'")
        if of["dtype"] == "video" or (of["dtype"] == "image" and of["shape"][2:] != (3,)):
            shape = list(of["shape"])
            raise ValueError(
                f"column {name!r} is {of['dtype']} {shape}, expected image [height, width, 3]"
            )


def _encoded(images: NDArray[np.uint8], kind: pa.DataType, pool: Executor) -> pa.Array:
    """Pictures [T, H, W, 3] as LeRobot's writer stores them."""
    files = pa.array(list(pool.map(_png, images)), pa.binary())
    paths = pa.array([f"frame-{frame:06d}.png" for frame in range(len(images))])
    return pa.StructArray.from_arrays([files, paths], fields=list(kind))


def _png(image: NDArray[np.uint8]) -> bytes:
    file = BytesIO()
    PIL.Image.fromarray(image).save(file, "PNG", compress_level=6)
    return file.getvalue()


def _blocks(spool: Path, recorded: _Recorded) -> Iterator[Block]:
    """Files of the size that LeRobot's have."""
    with pa.memory_map(str(spool)) as source, pa.ipc.open_file(source) as stored:
        held: list[pa.RecordBatch] = []
        for number in range(stored.num_record_batches):
            batch = stored.get_batch(number)
            if held and sum(each.nbytes for each in [*held, batch]) >= layout.FILE_MB * 2**20:
                yield _block(held, recorded, number)
                held = []
            held.append(batch)
        yield _block(held, recorded, stored.num_record_batches)


def _block(batches: list[pa.RecordBatch], recorded: _Recorded, stop: int) -> Block:
    """Of the episodes before `stop`, with the dataset's own id in `source.dataset`."""
    rows = pa.Table.from_batches(batches)
    place = rows.column_names.index("source.dataset")
    source = rows[place].to_numpy()
    named = pa.array(np.where(source == OWN, recorded.lineage.id, source))
    return Block(
        rows.set_column(place, "source.dataset", named),
        [len(batch) for batch in batches],
        recorded.tasks[stop - len(batches) : stop],
    )


def _write_endings(file: Path, endings: list[Mapping[str, Any]]) -> None:
    if endings:
        with open(file, "w", newline="", encoding="utf-8") as csv_file:
            table = csv.DictWriter(csv_file, list(endings[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(endings)
