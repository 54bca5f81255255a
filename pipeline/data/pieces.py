"""Parts of datasets, and their rows as they are stored."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.layout import arrow_schema, to_arrow
from pipeline.data.schema import CORE, Feature, column_dtype, missing_value


@dataclass(frozen=True)
class Piece:
    """Successive rows of one episode."""

    dataset: Dataset
    episode: int
    start: int
    """the first of its rows, counted in the dataset"""
    stop: int
    """the row after its last"""

    def __len__(self) -> int:
        return self.stop - self.start

    @property
    def task(self) -> str:
        """Of its episode."""
        return self.dataset.tasks[self.episode]


def whole(dataset: Dataset) -> list[Piece]:
    """A piece for each episode."""
    return [Piece(dataset, number, *bounds) for number, bounds in enumerate(dataset.bounds)]


def chosen(dataset: Dataset, rows: NDArray[np.bool_]) -> list[Piece]:
    """A piece for each run of neighbours in `rows` [N] of one episode, so that none has a gap."""
    return [
        Piece(dataset, number, start + run.start, start + run.stop)
        for number, (start, stop) in enumerate(dataset.bounds)
        for run in runs(rows[start:stop])
    ]


def runs(chosen: NDArray[np.bool_]) -> list[slice]:
    """Maximal runs of true in `chosen` bool [T], in order."""
    padded = np.concatenate([[False], chosen, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def stored_rows(
    pieces: Sequence[Piece], features: Mapping[str, Feature]
) -> Iterator[tuple[list[Piece], pa.Table]]:
    """The pieces that are in one data file, with their rows, one file after the other: the columns
    of `features` that are stored in rows, in that order.

    Of a column that its dataset lacks: a core column as `Dataset.columns`, else `missing_value`.
    """
    schema = pa.schema([field for field in arrow_schema(features) if field.name in features])
    for dataset, of_dataset in groupby(pieces, lambda piece: piece.dataset):
        there = [name for name in schema.names if dataset.has(name)]
        lacking = _lacking(dataset, {n: features[n] for n in schema.names if n not in there})
        for _, of_file in groupby(of_dataset, lambda piece: piece.dataset.file_of(piece.start)):
            here = list(of_file)
            rows = [(piece.start, piece.stop) for piece in here]
            table = pa.concat_tables(dataset.tables(rows, there))
            for name, values in lacking.items():
                kept = np.concatenate([values[start:stop] for start, stop in rows])
                table = table.append_column(name, to_arrow(kept, schema.field(name).type))
            yield here, table.select(schema.names).cast(schema).combine_chunks()


def _lacking(dataset: Dataset, features: Mapping[str, Feature]) -> dict[str, NDArray]:
    derived = dataset.columns(name for name in features if name in CORE)
    return derived | {
        name: np.full((len(dataset), *of["shape"]), missing_value(of), column_dtype(of))
        for name, of in features.items()
        if name not in derived
    }
