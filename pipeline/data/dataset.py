"""A LeRobot v3.0 dataset on this disk, opened and checked once. In the shapes, N is its rows.

LeRobot's loader creates a mistyped path and then asks the network for it, copies the data into a
cache, and takes 10 s to import. So the files are read themselves, after `open` has made sure that
LeRobot could load them.
"""

import hashlib
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data import stored
from pipeline.data.checks import check_complete, check_episodes, read_info
from pipeline.data.lineage import Lineage
from pipeline.data.schema import (
    CORE,
    LEROBOT_COLUMNS,
    SOURCE,
    Asked,
    Feature,
    channels_last,
    check_features,
    column_dtype,
    core_features,
    missing_value,
    pictures,
)

if TYPE_CHECKING:
    import pandas as pd

DRIVES = "drives.csv"
"""Beside meta/, in what was recorded: how each drive ended."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """What is known of a dataset without reading its rows; `open` makes one."""

    path: Path
    info: Mapping[str, Any]
    """meta/info.json"""
    features: dict[str, Feature]
    """LeRobot's description of each column, but of LeRobot's own"""
    lengths: NDArray[np.int64]
    """rows of each episode"""
    tasks: Sequence[str]
    """of each episode, that of its first row"""

    @classmethod
    def open(cls, path: Path) -> Self:
        """Check that `path` is a complete LeRobot v3.0 dataset, whoever wrote it. FileNotFoundError where
        there is nothing; ValueError where it is no dataset, half-written, of another format, or its
        parts disagree.
        """
        info = read_info(path)
        features: dict[str, Feature] = {
            name: channels_last({**feature, "shape": tuple(feature["shape"])})
            for name, feature in info["features"].items()
            if name not in LEROBOT_COLUMNS
        }
        check_complete(path, info)
        lengths, tasks = check_episodes(path)
        return cls(path, info, features, lengths, tasks)

    def __len__(self) -> int:
        return int(self.lengths.sum())

    @property
    def fps(self) -> int:
        """Frames per second."""
        return int(self.info["fps"])

    @property
    def cameras(self) -> list[str]:
        """The columns with pictures."""
        return pictures(self.features)

    @property
    def with_core(self) -> dict[str, Feature]:
        """Its features, and the core columns that it lacks."""
        core = core_features(self.features["action"])
        return self.features | {n: of for n, of in core.items() if n not in self.features}

    @property
    def is_demonstrated(self) -> bool:
        """Whether it has no core column but `action`: as somebody recorded who drove it all, so that
        `intervention` and `queried` are true in each row.
        """
        return not any(name in self.features for name in CORE if name != "action")

    @cached_property
    def bounds(self) -> list[tuple[int, int]]:
        """Of each episode the first of its rows and the one after its last."""
        stops = np.cumsum(self.lengths)
        return list(zip((stops - self.lengths).tolist(), stops.tolist(), strict=True))

    @cached_property
    def lineage(self) -> Lineage:
        """What it is and comes from: of a foreign one, a hash of its data files is all there is."""
        known = Lineage.read(self.path)
        if known is not None:
            return known
        digest = hashlib.sha256()
        for file in self.data_files:
            digest.update(file.read_bytes())
        return Lineage.foreign(digest.hexdigest())

    @property
    def drives(self) -> "pd.DataFrame":
        """How each drive that was recorded in it ended, as `write_dataset` wrote it down; empty where
        nobody did.
        """
        import pandas as pd

        file = self.path / DRIVES
        return pd.read_csv(file, keep_default_na=False) if file.is_file() else pd.DataFrame()

    @property
    def data_files(self) -> list[Path]:
        """In the order of the rows."""
        return stored.data_files(self.path)

    @property
    def episode_files(self) -> list[Path]:
        """With what is known of each episode, in their order."""
        return stored.episode_files(self.path)

    def file_of(self, row: int) -> int:
        """Which of `data_files` a row is in."""
        return bisect_right(self._first_rows, row) - 1

    @cached_property
    def _first_rows(self) -> list[int]:
        return stored.first_rows(self.data_files)

    def video_of(self, camera: str, episode: int) -> tuple[Path, float]:
        """The file that an episode is in, and when it begins there [s]."""
        chunk, number, begin = self._videos(camera)[episode]
        template = str(self.info["video_path"])
        return self.path / template.format(
            video_key=camera, chunk_index=chunk, file_index=number
        ), begin

    @cache  # noqa: B019 (a dataset is opened once, by a command that ends)
    def _videos(self, camera: str) -> list[tuple[int, int, float]]:
        """Of each episode the chunk and the file of its video, and when it begins there [s]."""
        names = ("chunk_index", "file_index", "from_timestamp")
        columns = [f"videos/{camera}/{name}" for name in names]
        parts = [pq.ParquetFile(file).read(columns) for file in self.episode_files]
        rows = pa.concat_tables(parts).to_pydict()
        return list(zip(*(rows[name] for name in columns), strict=True))

    def require(self, wanted: Mapping[str, Feature]) -> None:
        """Check that it has the columns `wanted`, of the same dtype, shape and names: a ValueError names
        the first that it has not, and both sides.
        """
        try:
            check_features(self.features, wanted)
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from None

    def require_robot_of(self, other: "Dataset") -> None:
        """Check that it is of the same robot as another one, at the same frame rate; ValueError if not."""
        for what in ("fps", "robot_type"):
            if self.info[what] != other.info[what]:
                raise ValueError(
                    f"{self.path}: {what} is {self.info[what]}, "
                    f"expected {other.info[what]} as in {other.path}"
                )

    def columns(self, names: Iterable[str]) -> dict[str, NDArray]:
        """All rows of the columns `names`, which are no pictures: [N, *shape], of their own dtype.

        Of a core column that the dataset lacks: where nobody wrote down what was `queried`, it is
        what the reference drove (`intervention`), or all where nobody wrote down that either, see
        `is_demonstrated`; `source.*` is the row's place here; else see `missing_value`. ValueError
        where there is no such column.
        """
        names = list(names)
        for name in names:
            if name in self.cameras or not (self.has(name) or name in CORE):
                raise ValueError(f"{self.path}: has no column {name!r} of numbers or text")
        stored_features = self.features | LEROBOT_COLUMNS
        there = stored.numbers(
            self.data_files, {name: stored_features[name] for name in names if self.has(name)}
        )
        return {name: there[name] if name in there else self._derived(name) for name in names}

    def column(self, name: str) -> NDArray:
        """The numbers [N] of a column of shape (1,); raises as `columns`."""
        return self.columns([name])[name][:, 0]

    @property
    def episode_index(self) -> NDArray[np.int64]:
        """[N], the episode of each row."""
        return np.repeat(np.arange(len(self.lengths)), self.lengths)

    def tables(self, rows: Iterable[tuple[int, int]], columns: Sequence[str]) -> Iterator[pa.Table]:
        """As `stored.tables`, of its data files."""
        return stored.tables(self.data_files, rows, columns)

    def has(self, name: str) -> bool:
        """Whether the column is stored, not only derived."""
        return name in self.features or name in LEROBOT_COLUMNS

    def _derived(self, name: str) -> NDArray:
        """A core column that nobody wrote down."""
        feature = self.with_core[name]
        shape, missing = (len(self), *feature["shape"]), missing_value(feature)
        values = np.full(shape, missing, column_dtype(feature))
        if name in ("intervention", "queried") and self.is_demonstrated:
            return np.ones(shape, bool)
        if name == "queried" and self.has("intervention"):
            return self.columns(["intervention"])["intervention"]
        if name == "asked_because":
            return np.where(self.columns(["queried"])["queried"], Asked.DROVE, values)
        if name == "ask_probability":
            return np.where(self.columns(["intervention"])["intervention"], np.float32(1), values)
        if name in SOURCE:
            firsts = np.repeat([start for start, _ in self.bounds], self.lengths)
            place = {
                "source.dataset": np.array(self.lineage.id),
                "source.iteration": np.array(-1),
                "source.episode": self.episode_index,
                "source.frame": np.arange(len(self)) - firsts,
            }[name]
            values[:, 0] = place
        return values
