"""What a dataset holds, as one hash."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pyarrow as pa

from pipeline.data.lineage import Lineage, Recipe
from pipeline.data.schema import PICTURES, Feature
from pipeline.data.stored import pngs, to_numpy


class ContentHash:
    """SHA-256 of what a dataset holds, and of how it was made: as with the commits of git, the same
    content made of other parents is something else. Told of the rows as they pass.

    The id that comes of it is no part of it: `OWN` stands for that in `source.dataset`.
    """

    def __init__(
        self, recipe: Recipe, features: Mapping[str, Feature], *, fps: int, robot: str
    ) -> None:
        listed = {name: [of["dtype"], *of["shape"]] for name, of in features.items()}
        made = [recipe.purpose, recipe.arguments, [parent.sha256 for parent in recipe.parents]]
        about = json.dumps([fps, robot, listed, made], sort_keys=True)
        self._recipe, self._features = recipe, features
        self._digest = hashlib.sha256(about.encode())

    def add(self, rows: pa.Table, lengths: Sequence[int], tasks: Sequence[str]) -> None:
        """The next episodes: their rows as they are stored, how many each has, and its task."""
        columns = [_content_of(rows[name], self._features[name]) for name in rows.column_names]
        start = 0
        for length, task in zip(lengths, tasks, strict=True):
            self._digest.update(json.dumps([task, length]).encode())
            for content in columns:
                self._digest.update(content(start, start + length))
            start += length

    def add_videos(self, begins: Sequence[float], files: Sequence[Path]) -> None:
        """Of a camera, when each episode begins in its video [s], and the videos."""
        self._digest.update(json.dumps(list(begins)).encode())
        for file in files:
            self._digest.update(file.read_bytes())

    def lineage(self) -> Lineage:
        """Of the dataset with all that."""
        return self._recipe.lineage(self._digest.hexdigest())


def _content_of(column: pa.ChunkedArray, feature: Feature) -> Callable[[int, int], bytes]:
    """What is hashed of the rows from the first number to before the second."""
    if feature["dtype"] in PICTURES:
        files = [len(png).to_bytes(8, "little") + png for png in pngs(column)]
        return lambda start, stop: b"".join(files[start:stop])
    values = to_numpy(column, feature)
    if feature["dtype"] == "string":
        return lambda start, stop: json.dumps(values[start:stop, 0].tolist()).encode()
    return lambda start, stop: values[start:stop].tobytes()
