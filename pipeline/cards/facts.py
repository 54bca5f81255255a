"""What there is to say of a dataset, counted from its columns. N is the number of its rows."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.data.reading import check_dataset, read_columns, read_numbers
from pipeline.data.schema import AFFORDANCES, FEATURES
from pipeline.world.affordances import FULL_ANGLE
from pipeline.world.tracks import LANE_WIDTH


@dataclass(frozen=True)
class Count:
    """Some rows of a dataset."""

    episodes: int
    """in which they are"""
    frames: int
    queries: int
    by_reference: int
    """frames that the reference drove"""


@dataclass(frozen=True)
class Facts:
    """A dataset in numbers."""

    name: str
    record_every: int
    """control steps in a frame"""
    total: Count
    scenarios: dict[str, Count]
    """by task, which is track and traffic"""
    iterations: dict[int, Count]
    """by the iteration in which a frame was first recorded"""
    judged: int
    """frames for which a safety policy gave its probability of safe"""
    called_unsafe: int
    """of these, the ones it called unsafe: the reference drove"""
    compared: int
    """frames whose deviation is known"""
    deviating: int
    """of these, the ones above tau"""
    braking: int
    """frames whose action brakes"""
    offset: tuple[float, float]
    """[m] from the middle of the lane, at most, in half and in 95 % of the frames"""
    angle: tuple[float, float]
    """[rad] to the lane, the same"""
    cut_out: int
    """episodes that begin within a drive"""
    single: int
    """episodes of one frame"""
    unknown: dict[str, int]
    """by column: frames in which it is NaN"""


def read_facts(path: Path, tau: float) -> Facts:
    """Count a dataset; a deviation above `tau` is one too many.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    columns = read_columns(path)
    episode = columns["episode_index"]
    _, firsts, lengths = np.unique(episode, return_index=True, return_counts=True)
    intervention = columns["intervention"][:, 0]
    judged = ~np.isnan(columns["safe_probability"][:, 0])
    deviation = columns["deviation"][:, 0]
    affordances = columns["affordances"]

    def count(rows: NDArray[np.bool_]) -> Count:
        return Count(
            episodes=len(np.unique(episode[rows])),
            frames=int(rows.sum()),
            queries=int(columns["queried"][rows].sum()),
            by_reference=int(intervention[rows].sum()),
        )

    return Facts(
        name=path.name,
        record_every=check_dataset(path),
        total=count(np.ones(len(episode), bool)),
        scenarios=_by(_tasks(path), count),
        iterations=_by(columns["source.iteration"][:, 0], count),
        judged=int(judged.sum()),
        called_unsafe=int((judged & intervention).sum()),
        compared=int((~np.isnan(deviation)).sum()),
        deviating=int((deviation > tau).sum()),
        offset=_within(affordances[:, AFFORDANCES.index("lane_position")] * LANE_WIDTH / 2),
        angle=_within(affordances[:, AFFORDANCES.index("lane_angle")] * FULL_ANGLE),
        braking=int((columns["action"][:, 1] > 0).sum()),
        cut_out=int((columns["source.frame"][firsts, 0] > 0).sum()),
        single=int((lengths == 1).sum()),
        unknown={
            name: int(np.isnan(columns[name]).any(axis=1).sum())
            for name, feature in FEATURES.items()
            if feature["dtype"] == "float32"
        },
    )


def _within(amount: NDArray[np.floating]) -> tuple[float, float]:
    """The sizes that half and that 95 % of `amount` [N] do not exceed."""
    half, most = np.quantile(np.abs(amount), (0.5, 0.95))
    return float(half), float(most)


def _by[Key](keys: NDArray, count: Callable[[NDArray[np.bool_]], Count]) -> dict[Key, Count]:
    """Counts by each of `keys` [N], sorted."""
    return {key: count(keys == key) for key in np.unique(keys).tolist()}


def _tasks(path: Path) -> NDArray[np.str_]:
    """The task of each row, [N]."""
    tasks = pq.read_table(path / "meta" / "tasks.parquet").to_pydict()
    names = dict(zip(tasks["task_index"], tasks["task"], strict=True))
    index = read_numbers(path, ["task_index"])["task_index"][:, 0]
    return np.array([names[i] for i in index.tolist()])
