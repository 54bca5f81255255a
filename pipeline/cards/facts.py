"""What there is to say of a dataset, counted from its columns. N is the number of its rows."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.driving.affordances import FULL_ANGLE
from pipeline.driving.features import AFFORDANCES, CONTROL_HZ, IMITATED
from pipeline.driving.tracks import LANE_WIDTH
from pipeline.rollout.judgement import judgements


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
    action_repeat: int
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
    """frames of a rollout by a safety policy in which both actions are known"""
    deviating: int
    """of these, the ones that its labels call unsafe"""
    unsafe_is: tuple[str, ...]
    """by these labels: what is above which tau, in words"""
    endings: dict[str, int]
    """drives that were recorded here, by how they ended"""
    braking: int
    """frames whose action brakes"""
    offset: tuple[float, float] | None
    """[m] from the middle of the lane, at most, in half and in 95 % of the frames; None without any"""
    angle: tuple[float, float] | None
    """[rad] to the lane, the same"""
    cut_out: int
    """episodes that begin within a drive"""
    single: int
    """episodes of one frame"""
    unknown: dict[str, int]
    """by column: frames in which it is NaN"""


def read_facts(dataset: Dataset) -> Facts:
    """Count a dataset of the car's.

    Raises:
        ValueError: it is another robot's.
    """
    dataset.require(IMITATED)
    columns = dataset.columns(n for n in dataset.with_core if n not in dataset.cameras)
    episode, lengths = dataset.episode_index, dataset.lengths
    intervention = columns["intervention"][:, 0]
    judged = ~np.isnan(columns["safe_probability"][:, 0])
    affordances = columns["affordances"]
    compared, deviating, unsafe_is = _unsafe(dataset, columns)

    def count(rows: NDArray[np.bool_]) -> Count:
        return Count(
            episodes=len(np.unique(episode[rows])),
            frames=int(rows.sum()),
            queries=int(columns["queried"][rows].sum()),
            by_reference=int(intervention[rows].sum()),
        )

    firsts = [start for start, _ in dataset.bounds]
    return Facts(
        name=dataset.path.name,
        action_repeat=CONTROL_HZ // dataset.fps,
        total=count(np.ones(len(dataset), bool)),
        scenarios=_by(np.repeat(np.array(dataset.tasks, dtype=str), lengths), count),
        iterations=_by(columns["source.iteration"][:, 0], count),
        judged=int(judged.sum()),
        called_unsafe=int((judged & intervention).sum()),
        compared=compared,
        deviating=deviating,
        unsafe_is=unsafe_is,
        endings=dict(Counter(drive["ended"] for drive in dataset.drives)),
        offset=_within(affordances[:, AFFORDANCES.index("lane_position")] * LANE_WIDTH / 2),
        angle=_within(affordances[:, AFFORDANCES.index("lane_angle")] * FULL_ANGLE),
        braking=int((columns["action"][:, 1] > 0).sum()),
        cut_out=int((columns["source.frame"][firsts, 0] > 0).sum()),
        single=int((lengths == 1).sum()),
        unknown={
            name: int(np.isnan(values).any(axis=1).sum())
            for name, values in columns.items()
            if values.dtype.kind == "f"
        },
    )


def _unsafe(dataset: Dataset, columns: dict[str, NDArray]) -> tuple[int, int, tuple[str, ...]]:
    """Frames that can be compared, those of them that are unsafe, and by what labels."""
    compared = deviating = 0
    words = []
    for source, judgement in sorted(judgements(dataset.lineage).items()):
        rows = (columns["source.dataset"][:, 0] == source) & columns["queried"][:, 0]
        if rows.any():
            epsilon = judgement.deviation(columns["primary_action"][rows], columns["action"][rows])
            compared += int((~np.isnan(epsilon)).sum())
            deviating += int((epsilon > judgement.tau).sum())
            words.append(f"deviation of {judgement.words} above tau = {judgement.tau:g}")
    return compared, deviating, tuple(dict.fromkeys(words))


def _within(amount: NDArray[np.floating]) -> tuple[float, float] | None:
    """The sizes that half and that 95 % of `amount` [N] do not exceed."""
    if len(amount) == 0:
        return None
    half, most = np.quantile(np.abs(amount), (0.5, 0.95))
    return float(half), float(most)


def _by[Key](keys: NDArray, count: Callable[[NDArray[np.bool_]], Count]) -> dict[Key, Count]:
    """Counts by each of `keys` [N], sorted."""
    return {key: count(keys == key) for key in np.unique(keys).tolist()}
