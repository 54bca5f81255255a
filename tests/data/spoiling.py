"""Ways to spoil a copy of a dataset."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.data.dataset import Dataset
from pipeline.driving.features import CAMERA
from tests.files import rewrite

DATA = Path("data", "chunk-000", "file-000.parquet")
EPISODES = Path("meta", "episodes", "chunk-000", "file-000.parquet")
Spoil = Callable[[Path], None]


def copy(dataset: Dataset, path: Path) -> Path:
    """A copy to spoil."""
    shutil.copytree(dataset.path, path)
    return path


def change_info(**changes: Any) -> Spoil:
    return lambda path: rewrite(path / "meta" / "info.json", **changes)


def change_feature(name: str, **changes: Any) -> Spoil:
    def change(path: Path) -> None:
        features = json.loads((path / "meta" / "info.json").read_text())["features"]
        features[name] = {**features.get(name, {}), **changes}
        change_info(features=features)(path)

    return change


def cut_short(part: Path) -> Spoil:
    def change(path: Path) -> None:
        whole = (path / part).read_bytes()
        (path / part).write_bytes(whole[: len(whole) // 2])

    return change


def lose(part: str | Path) -> Spoil:
    def change(path: Path) -> None:
        victim = path / part
        shutil.rmtree(victim) if victim.is_dir() else victim.unlink()

    return change


def drop_column(*names: str) -> Spoil:
    """From the rows and from info.json, as LeRobot's tool removes a feature."""

    def change(path: Path) -> None:
        drop_parquet_column(*names)(path)
        features = json.loads((path / "meta" / "info.json").read_text())["features"]
        change_info(features={n: of for n, of in features.items() if n not in names})(path)

    return change


def drop_parquet_column(*names: str) -> Spoil:
    def change(path: Path) -> None:
        table = pq.ParquetFile(path / DATA).read().drop_columns(list(names))
        pq.write_table(table, path / DATA)

    return change


def set_column(file: Path, name: str, change: Callable[[list], list]) -> Spoil:
    """Other values in a column of a parquet file."""

    def spoil(path: Path) -> None:
        table = pq.ParquetFile(path / file).read()
        values = pa.array(change(table[name].to_pylist()), table.field(name).type)
        place = table.column_names.index(name)
        pq.write_table(table.set_column(place, table.field(name), values), path / file)

    return spoil


def set_last_image(png: bytes) -> Spoil:
    return set_column(DATA, CAMERA, lambda cells: [*cells[:-1], {"bytes": png, "path": "x.png"}])
