"""Recordings read back from the file."""

from pathlib import Path
from typing import Any

from rerun.experimental import RrdReader, StoreEntry


def recordings(path: Path) -> list[StoreEntry]:
    return RrdReader(path).recordings()


def batches(path: Path, entry: StoreEntry, entity: str, component: str) -> list[list[Any]]:
    """What an entity shows, in the order of time: the values of each row."""
    rows: list[tuple[int, list[Any]]] = []
    for chunk in RrdReader(path).stream(store=entry).to_chunks():
        if chunk.entity_path == entity and chunk.timeline_names:
            batch = chunk.to_record_batch().to_pydict()
            values = batch[next(name for name in batch if name.endswith(component))]
            rows += zip(batch["frame_index"], values, strict=True)
    return [values for _, values in sorted(rows, key=lambda row: row[0])]


def column(path: Path, entry: StoreEntry, entity: str, component: str) -> list[Any]:
    """What an entity shows, in the order of time: the only value of each row, or None."""
    return [values[0] for values in batches(path, entry, entity, component)]


def origins(path: Path) -> set[str]:
    """Where the views of a file's blueprint have their roots."""
    (blueprint,) = RrdReader(path).blueprints()
    chunks = RrdReader(path).stream(store=blueprint).to_chunks()
    found = (chunk.to_record_batch().to_pydict() for chunk in chunks)
    name = "ViewBlueprint:space_origin"
    return {batch[name][0][0] for batch in found if name in batch}
