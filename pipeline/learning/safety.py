"""What a safety policy learns from, and how well it did: frames judged by where its primary
deviates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_all
from pipeline.data.labels import labelled
from pipeline.learning.labels import LabelRule
from pipeline.policies.inference import propose
from pipeline.policies.network import Actor

MOST = 10.0
"""What a frame counts for in training at most: one that was audited stands for 1 / `ask_probability`,
and few that stand for very many would be all that is learned.
"""


@dataclass(frozen=True)
class Judged:
    """Frames with a primary's features and its deviation from the reference. N frames, F features."""

    features: NDArray[np.float16]
    """[N, F], what the primary looked at"""
    deviation: NDArray[np.float64]
    """[N], what Eq. 2 compares with tau"""
    episode_index: NDArray[np.int64]
    """[N]"""
    weight: NDArray[np.float64]
    """[N], [1, MOST]: for how many frames that were driven it stands"""

    def __add__(self, other: Judged) -> Judged:
        """The frames of both, the other's episodes numbered on."""
        first = int(self.episode_index.max(initial=-1)) + 1
        return Judged(
            np.concatenate([self.features, other.features]),
            np.concatenate([self.deviation, other.deviation]),
            np.concatenate([self.episode_index, other.episode_index + first]),
            np.concatenate([self.weight, other.weight]),
        )

    def only(self, rows: NDArray[np.bool_]) -> Judged:
        """The frames where `rows` [N] is true."""
        return Judged(*(column[rows] for column in vars(self).values()))


def proposals(
    primary: Actor, dataset: Dataset
) -> tuple[NDArray[np.float32], NDArray[np.float16], NDArray[np.float32], NDArray[np.int64]]:
    """What a primary would do in the frames of a dataset that carry the reference's action, [N, A]; what
    it looked at, [N, F]; the reference's actions, [N, A]; and [N], which run of neighbours with a label
    each frame is in. ValueError for another robot's dataset, or one without a label of the reference.
    """
    dataset.require({**primary.seen, "action": primary.action})
    rows, run = labelled(dataset)
    columns = read_all(dataset, ["action", *primary.seen], rows)
    return *propose(primary, columns), columns["action"], run


def judge(primary: Actor, dataset: Dataset, *, rule: LabelRule) -> Judged:
    """Run a primary over the frames of a dataset that carry the reference's action; what counts as a
    deviation, the rule says. Raises as `proposals`.
    """
    proposed, features, actions, run = proposals(primary, dataset)
    epsilon = rule.deviation(proposed, actions, run, dataset.fps)
    probability = dataset.column("ask_probability")[dataset.column("queried")]
    asked = np.nan_to_num(probability.astype(float), nan=1.0)
    return Judged(features, epsilon, run, 1 / asked.clip(1 / MOST))


def apart(judged: Judged, share: float, rng: np.random.Generator, name: str) -> NDArray[np.bool_]:
    """[N] true for the frames of a random `share` of the episodes; ValueError, that calls it `name`, where
    one side would be left without any.
    """
    episodes = np.unique(judged.episode_index)
    count = round(share * len(episodes))
    if not 0 < count < len(episodes):
        raise ValueError(
            f"{name} is {share} of {len(episodes)} episodes, expected some on both sides"
        )
    return np.isin(judged.episode_index, rng.permutation(episodes)[:count])
