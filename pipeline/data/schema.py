"""The one schema that every dataset has, and an episode in memory.

In the shapes, T is the number of rows (recorded frames) of an episode.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

CONTROL_HZ = 30
"""Control frames per second of the world. A dataset records every k-th one: its fps is 30 / k."""

ROBOT_TYPE = "safedagger_car"
CAMERA = "observation.images.front"
IMAGE_SHAPE = (72, 160, 3)
ACTIONS = ("steering", "brake")
AFFORDANCES = (
    "lane_left",
    "lane_right",
    "car_left",
    "car_ahead",
    "car_right",
    "distance_left",
    "distance_ahead",
    "distance_right",
    "lane_position",
    "lane_angle",
)
"""The ten hidden variables of the paper's Appendix A, in its order."""
VEHICLE_STATE = ("x", "y", "heading", "speed")
"""Where our car is in the world [m, m, rad] and how fast [m/s]: to look at, no policy sees it."""

_FLAG = {"dtype": "bool", "shape": (1,), "names": None}
_NUMBER = {"dtype": "float32", "shape": (1,), "names": None}
_INDEX = {"dtype": "int64", "shape": (1,), "names": None}
_ACTION = {"dtype": "float32", "shape": (len(ACTIONS),), "names": list(ACTIONS)}

FEATURES: dict[str, dict[str, Any]] = {
    CAMERA: {"dtype": "image", "shape": IMAGE_SHAPE, "names": ["height", "width", "channel"]},
    # steering [-1, 1], brake {0, 1}: the reference's where it was queried, else the primary's
    "action": _ACTION,
    # what the primary proposed; NaN where it was not asked
    "primary_action": _ACTION,
    "affordances": {
        "dtype": "float32",
        "shape": (len(AFFORDANCES),),
        "names": list(AFFORDANCES),
    },
    "vehicle_state": {
        "dtype": "float32",
        "shape": (len(VEHICLE_STATE),),
        "names": list(VEHICLE_STATE),
    },
    # the reference drove this row
    "intervention": _FLAG,
    # the reference was asked for an action that is used to drive or to train
    "queried": _FLAG,
    # the safety policy's probability that the primary is safe here, [0, 1]; NaN where there is none
    "safe_probability": _NUMBER,
    # squared difference of primary and reference steering, [0, 4]; NaN unless both are known
    "deviation": _NUMBER,
    # where this row was first recorded: never rewritten by selecting or merging
    "source.iteration": _INDEX,
    "source.episode": _INDEX,
    "source.frame": _INDEX,
}
"""LeRobot features. LeRobot merges only datasets whose features are identical."""

COLUMNS: tuple[str, ...] = tuple(name for name in FEATURES if name != CAMERA)
"""The columns that are not images."""

LEROBOT_COLUMNS = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
"""The columns that LeRobot adds to every dataset, all of shape (1,), with their dtypes."""


def column_dtype(name: str) -> np.dtype:
    """The numpy dtype of column `name` in memory."""
    return np.dtype("uint8" if name == CAMERA else FEATURES[name]["dtype"])


def check_record_every(record_every: int) -> int:
    """Return the fps of a dataset that records every `record_every`-th control frame.

    Raises:
        ValueError: `record_every` does not divide `CONTROL_HZ`; the fps would not be whole.
    """
    if record_every < 1 or CONTROL_HZ % record_every:
        raise ValueError(f"record_every is {record_every}, expected a divisor of {CONTROL_HZ}")
    return CONTROL_HZ // record_every


@dataclass(frozen=True, eq=False)
class Episode:
    """Contiguous recorded frames of one drive.

    Raises:
        ValueError: a column is missing, unknown, or of another dtype, shape or length; no rows.
    """

    task: str
    """The scenario: track and traffic, e.g. "coast, 20 cars"."""
    columns: dict[str, np.ndarray] = field(repr=False)
    """Every key of `FEATURES`: [T, *shape] of its exact dtype; images uint8 [T, 72, 160, 3]."""

    def __post_init__(self) -> None:
        if not isinstance(self.task, str) or not self.task:
            raise ValueError(f"task is {self.task!r}, expected a description of the scenario")
        for name in (*FEATURES, *self.columns):
            if name not in self.columns or name not in FEATURES:
                problem = "missing" if name in FEATURES else "unknown"
                raise ValueError(f"column {name!r} of the episode is {problem}")
        rows = len(self.columns[CAMERA])
        if rows == 0:
            raise ValueError("the episode has no rows, expected at least one")
        for name, feature in FEATURES.items():
            found, dtype, shape = self.columns[name], column_dtype(name), (rows, *feature["shape"])
            if found.dtype != dtype or found.shape != shape:
                raise ValueError(
                    f"column {name!r} of the episode is {found.dtype} {found.shape}, "
                    f"expected {dtype} {shape}"
                )

    def __len__(self) -> int:
        return len(self.columns[CAMERA])

    def rows(self, start: int, stop: int) -> "Episode":
        """Rows `start` (inclusive) to `stop` (exclusive) as an episode that shares the memory."""
        return Episode(self.task, {name: rows[start:stop] for name, rows in self.columns.items()})
