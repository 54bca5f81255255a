"""Make the files of a finished dataset a function of its content alone.

What LeRobot leaves behind depends on more: the order of the keys in stats.json on PYTHONHASHSEED,
the metadata of the parquet files on the absolute path. DVC would take equal data for changed data.
And the statistics of a column with NaN are NaN, which is not JSON.
"""

import json
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.data.reading import read_numbers
from pipeline.data.schema import COLUMNS, LEROBOT_COLUMNS

Statistics = dict[str, list[Any]]
_STATISTICS = ("min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99")


def canonicalise(root: Path) -> None:
    """Rewrite in place whatever depends on more than content. Twice is the same as once."""
    columns = read_numbers(root, [*COLUMNS, *LEROBOT_COLUMNS])
    overall = {name: finite_statistics(values) for name, values in columns.items()}
    _rewrite_statistics(root / "meta" / "stats.json", overall)
    for file in sorted((root / "meta" / "episodes").glob("*/*.parquet")):
        _rewrite_episode_statistics(file, columns, overall)
    for file in sorted((root / "data").glob("*/*.parquet")):
        _strip_fingerprint(file)
    # where LeRobot staged its PNG files: empty by now
    shutil.rmtree(root / "images", ignore_errors=True)


def finite_statistics(values: np.ndarray) -> Statistics | None:
    """LeRobot's statistics (min, max, mean, std, count, quantiles) of the rows without NaN.

    Args:
        values: [N, D].

    Returns:
        For each statistic a list of D numbers, and "count" of one; None where no row is finite.
    """
    from lerobot.datasets import get_feature_stats

    finite = values[np.isfinite(values).all(axis=1)]
    if len(finite) == 0:
        return None
    statistics = get_feature_stats(finite.astype(np.float64), axis=0, keepdims=False)
    return {name: value.tolist() for name, value in statistics.items()}


def _rewrite_statistics(file: Path, overall: dict[str, Statistics | None]) -> None:
    """Sorted keys, and every column but the images anew from all its rows.

    LeRobot's own are wrong after a merge: means of quantiles, and indices from before. A column
    without a finite value has no entry, as LeRobot does with strings: a count of zero would have
    `aggregate_stats` divide by zero, and any minimum would spread to what it is merged with.
    """
    statistics = {**json.loads(file.read_text(encoding="utf-8")), **overall}
    known = {name: value for name, value in statistics.items() if value is not None}
    text = json.dumps(known, indent=4, sort_keys=True, allow_nan=False)
    file.write_text(text + "\n", encoding="utf-8")


def _rewrite_episode_statistics(
    file: Path, columns: dict[str, np.ndarray], overall: dict[str, Statistics | None]
) -> None:
    """One type for all, and the statistics of the episodes with NaN anew.

    LeRobot keeps the minimum of a flag as a flag where every episode is a single row, and cannot
    merge that with the numbers that it writes otherwise.

    Here every column must have an entry, so an episode without a finite value has the statistics
    of the whole dataset with a count of zero: whoever aggregates episodes gets the right minimum,
    maximum and mean. Zeros where the dataset has no finite value either.
    """
    table = pq.ParquetFile(file).read()
    bounds = zip(
        *(table[f"dataset_{end}_index"].to_pylist() for end in ("from", "to")), strict=True
    )
    episodes = [slice(start, stop) for start, stop in bounds]
    for name, values in columns.items():
        finite = np.isfinite(values)
        anew = {
            number: finite_statistics(values[rows]) or _placeholder(overall[name], values.shape[1])
            for number, rows in enumerate(episodes)
            if not finite[rows].all()
        }
        for statistic in _STATISTICS:
            key = f"stats/{name}/{statistic}"
            kind = pa.list_(pa.int64() if statistic == "count" else pa.float64())
            cells = table[key].cast(kind)
            if anew:
                listed = cells.to_pylist()
                for number, statistics in anew.items():
                    listed[number] = statistics[statistic]
                cells = pa.array(listed, kind)
            table = table.set_column(table.column_names.index(key), key, cells)
    pq.write_table(table, file, compression="snappy")


def _placeholder(overall: Statistics | None, numbers: int) -> Statistics:
    zeros = dict.fromkeys(_STATISTICS, [0.0] * numbers)
    return {**(overall or zeros), "count": [0]}


def _strip_fingerprint(file: Path) -> None:
    """Drop from the metadata what `datasets` derives from the absolute paths of the images."""
    stripped = file.with_suffix(".stripped")
    with pq.ParquetFile(file) as source:
        metadata = dict(source.schema_arrow.metadata)
        about = json.loads(metadata[b"huggingface"])
        about.pop("fingerprint", None)
        metadata[b"huggingface"] = json.dumps(about).encode()
        schema = source.schema_arrow.with_metadata(metadata)
        with pq.ParquetWriter(stripped, schema, compression="snappy") as target:
            # one row group per episode, as LeRobot has it
            for group in range(source.num_row_groups):
                rows = source.read_row_group(group)
                target.write_table(rows.replace_schema_metadata(metadata))
    os.replace(stripped, file)
