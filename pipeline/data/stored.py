"""The rows of a dataset as they are stored: parquet files, read by what is asked of them."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data.schema import Feature, column_dtype


def data_files(path: Path) -> list[Path]:
    """The files with the rows of the dataset in `path`, in the order of the rows."""
    return sorted((path / "data").glob("*/*.parquet"))


def episode_files(path: Path) -> list[Path]:
    """The files with what is known of each episode, in their order."""
    return sorted((path / "meta" / "episodes").glob("*/*.parquet"))


def first_rows(files: Sequence[Path]) -> list[int]:
    """Of each file the first of its rows in the dataset."""
    return np.cumsum([0, *(pq.read_metadata(file).num_rows for file in files)])[:-1].tolist()


def numbers(files: Sequence[Path], features: Mapping[str, Feature]) -> dict[str, NDArray]:
    """All rows of the columns `features`, which are no pictures: [N, *shape] of their own dtype."""
    parts = [pq.ParquetFile(file).read(columns=list(features)) for file in files]
    return {
        name: np.concatenate([to_numpy(part[name], feature) for part in parts])
        for name, feature in features.items()
    }


def to_numpy(column: pa.ChunkedArray, feature: Feature) -> NDArray:
    """A column as [N, *shape] of its own dtype."""
    dtype, chunks = column_dtype(feature), [flat(chunk) for chunk in column.chunks]
    parts = [chunk.to_numpy(zero_copy_only=False) for chunk in chunks] or [np.empty(0, dtype)]
    return np.concatenate(parts).astype(dtype, copy=False).reshape(-1, *feature["shape"])


def flat(values: pa.Array) -> pa.Array:
    """The numbers of vectors and matrices one after the other, whatever kind of list they are in."""
    if isinstance(values, pa.ExtensionArray):
        values = values.storage
    while pa.types.is_list(values.type) or pa.types.is_fixed_size_list(values.type):
        values = values.flatten()
    return values


def pngs(column: pa.ChunkedArray) -> list[bytes]:
    """The files in a column of images."""
    return [png for chunk in column.chunks for png in chunk.field("bytes").to_pylist()]


def tables(
    files: Sequence[Path], rows: Iterable[tuple[int, int]], columns: Sequence[str]
) -> Iterator[pa.Table]:
    """The rows from `start` to before `stop` for each (start, stop) of `rows`, within one file each, as
    they are stored, of some `columns`. Those of one row group that follow each other read it once.
    """
    groups = _row_groups(files)
    starts = [start for _, _, start in groups]
    reader, file_read = None, None
    held, table = None, None
    for start, stop in rows:
        first = bisect_right(starts, start) - 1
        last = bisect_right(starts, max(stop - 1, start))
        file = groups[first][0]
        if file != file_read:
            reader, file_read = pq.ParquetFile(file), file
        if (first, last) != held or table is None:
            assert reader is not None
            numbers = [number for _, number, _ in groups[first:last]]
            table, held = reader.read_row_groups(numbers, columns=columns), (first, last)
        yield table.slice(start - starts[first], stop - start)


def _row_groups(files: Iterable[Path]) -> list[tuple[Path, int, int]]:
    """Of each its file, its number there, and the first of its rows in the dataset."""
    found, start = [], 0
    for file in files:
        metadata = pq.read_metadata(file)
        for number in range(metadata.num_row_groups):
            found.append((file, number, start))
            start += metadata.row_group(number).num_rows
    return found
