"""The schema of a dataset: core columns, whatever the task, and those that a task and its policies
add; and an episode in memory.

In the shapes, T is the number of rows (recorded frames) of an episode.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

Feature = Mapping[str, Any]
"""A column as LeRobot describes it: "dtype", "shape" and "names"."""

PICTURES = ("image", "video")
"""The dtypes of what a camera saw: [T, height, width, channels]."""

SIGNAL = "signal."
"""What the name of a policy's signal beyond the core columns begins with."""

LEROBOT_COLUMNS: dict[str, Feature] = {
    "timestamp": {"dtype": "float32", "shape": (1,), "names": None},
    **{
        name: {"dtype": "int64", "shape": (1,), "names": None}
        for name in ("frame_index", "episode_index", "index", "task_index")
    },
}
"""The columns that LeRobot adds to every dataset."""


class Asked(IntEnum):
    """Why the reference was asked about a frame."""

    NOT = -1
    """it was not"""
    DROVE = 0
    """it drove"""
    AUDIT = 1
    """to learn what the safety policy misses"""
    MIXTURE = 2
    """DAgger asks about every frame, whoever drives"""
    AFTERWARDS = 3
    """when the drive was over"""


_FLAG: Feature = {"dtype": "bool", "shape": (1,), "names": None}
_NUMBER: Feature = {"dtype": "float32", "shape": (1,), "names": None}
_INDEX: Feature = {"dtype": "int64", "shape": (1,), "names": None}

SOURCE = ("source.dataset", "source.iteration", "source.episode", "source.frame")
"""Where a row was first recorded, which is its identity: selecting and merging never rewrite it."""
OWN = -1
"""In `source.dataset`: the dataset that is being written, whose id nobody can know before."""


def core_features(action: Feature) -> dict[str, Feature]:
    """The columns that every dataset has, where a policy's action is described by `action`."""
    return {
        # the reference's where it was queried, else what the primary did
        "action": action,
        # what the primary proposed; NaN where it was not asked
        "primary_action": action,
        # the reference drove this row
        "intervention": _FLAG,
        # the reference was asked for an action that is used to drive or to train
        "queried": _FLAG,
        # the safety policy's probability that the primary is safe here, [0, 1]; NaN where there is none
        "safe_probability": _NUMBER,
        # epsilon of Sec. 3.1, the task's measure of how far the two actions are apart; NaN unless both are known
        "deviation": _NUMBER,
        # one of `Asked`
        "asked_because": _INDEX,
        # with which probability the reference was asked here, [0, 1]; NaN where that is not known
        "ask_probability": _NUMBER,
        # the first 63 bits of the id of the dataset (see `lineage`)
        **dict.fromkeys(SOURCE, _INDEX),
    }


CORE = tuple(core_features({}))
"""The names of the core columns."""


def may_be_missing(name: str) -> bool:
    """Whether a dataset without the column `name` can be merged with one that has it."""
    return name.startswith(SIGNAL) or (name in CORE and name != "action")


def missing_value(feature: Feature) -> float | bool | int:
    """What stands in a column where there is nothing to know: NaN, false or -1."""
    kind = np.dtype(feature["dtype"]).kind
    return {"f": np.nan, "b": False, "i": -1}[kind]


def pictures(features: Mapping[str, Feature]) -> list[str]:
    """The names of the cameras."""
    return [name for name, feature in features.items() if feature["dtype"] in PICTURES]


def channels_last(feature: Feature) -> Feature:
    """The description of a picture as it is in memory, where LeRobot's names say that channels come first;
    of all else as it is.
    """
    names = feature.get("names")
    if feature["dtype"] not in PICTURES or not names or names[0] not in ("channel", "channels"):
        return feature
    (channels, *others), (name, *beside) = feature["shape"], names
    return {**feature, "shape": (*others, channels), "names": [*beside, name]}


def column_dtype(feature: Feature) -> np.dtype:
    """The numpy dtype of a column in memory; of text it is object."""
    kind = feature["dtype"]
    return np.dtype("uint8" if kind in PICTURES else "O" if kind == "string" else kind)


def check_features(features: Mapping[str, Feature], wanted: Mapping[str, Feature]) -> None:
    """Check that all of the columns `wanted` are among `features`, of the same dtype, shape and names;
    where `wanted` has no names, any will do. A ValueError names the first that is not, and both sides.
    """
    for name, feature in wanted.items():
        if name not in features:
            raise ValueError(f"column {name!r} is missing, expected {_describe(feature)}")
        found = features[name] if feature.get("names") else {**features[name], "names": None}
        if _describe(found) != _describe(feature):
            raise ValueError(
                f"column {name!r} is {_describe(features[name])}, expected {_describe(feature)}"
            )


def _describe(feature: Feature) -> str:
    names = feature.get("names")
    return f"{feature['dtype']} {list(feature['shape'])}" + (f" {names}" if names else "")


@dataclass(frozen=True, eq=False)
class Episode:
    """Contiguous recorded frames of one drive, at least one; ValueError where a column is missing, unknown,
    or of another dtype, shape or length.
    """

    task: str
    """The scenario, e.g. "drive on alder with 20 other cars"."""
    columns: dict[str, np.ndarray] = field(repr=False)
    """Every key of `features`: [T, *shape] of its exact dtype; pictures are uint8."""
    features: Mapping[str, Feature] = field(repr=False)
    """LeRobot's description of each column."""
    ending: Mapping[str, Any] | None = None
    """How the drive ended, by name, if this is a whole drive that was just recorded."""

    def __post_init__(self) -> None:
        if not isinstance(self.task, str) or not self.task:
            raise ValueError(f"task is {self.task!r}, expected a description of the scenario")
        for name in sorted(self.features.keys() ^ self.columns.keys()):
            problem = "missing" if name in self.features else "unknown"
            raise ValueError(f"column {name!r} of the episode is {problem}")
        rows = len(self)
        if rows == 0:
            raise ValueError("the episode has no rows, expected at least one")
        for name, feature in self.features.items():
            found = self.columns[name]
            dtype, shape = column_dtype(feature), (rows, *feature["shape"])
            if found.dtype != dtype or found.shape != shape:
                raise ValueError(
                    f"column {name!r} of the episode is {found.dtype} {found.shape}, "
                    f"expected {dtype} {shape}"
                )

    def __len__(self) -> int:
        return len(self.columns["source.frame"])

    def rows(self, start: int, stop: int) -> "Episode":
        """Rows `start` (inclusive) to `stop` (exclusive) as an episode that shares the memory."""
        rows = {name: values[start:stop] for name, values in self.columns.items()}
        return Episode(self.task, rows, self.features)
