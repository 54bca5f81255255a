"""How well a safety policy tells unsafe frames, in any labelled dataset, and in which situations.

In the shapes, N is the number of frames and A of the numbers in an action.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.learning.labels import LabelRule
from pipeline.learning.quality import detection_quality
from pipeline.learning.safety import proposals
from pipeline.learning.training import safe_probabilities
from pipeline.policies.network import Actor, SafetyNetwork

ALL = "all"
"""The situation that every frame is in."""


@dataclass(frozen=True)
class Frames:
    """What is known of the frames of a dataset that have a label."""

    proposed: NDArray[np.float32]
    """[N, A], what the primary would do"""
    actions: NDArray[np.float32]
    """[N, A], what the reference would"""
    deviation: NDArray[np.float64]
    """[N], by the labels"""
    probability: NDArray[np.float32]
    """[N], of being safe"""
    numbers: pd.DataFrame
    """[N], what `situations` are told by: each number of the dataset's columns that has a name,
    whether the reference drove (`intervention`), and the seconds since it last handed the robot back
    (`since_handover`; NaN while it drives, and before it has)"""
    run: NDArray[np.int64]
    """[N], which run of neighbours with a label each is in"""
    fps: int


def look_at(primary: Actor, safety: SafetyNetwork, dataset: Dataset, rule: LabelRule) -> Frames:
    """Run both policies over the frames of a dataset that have a label. Raises as `safety.proposals`."""
    proposed, features, actions, run = proposals(primary, dataset)
    return Frames(
        proposed,
        actions,
        rule.deviation(proposed, actions, run, dataset.fps),
        safe_probabilities(safety, features),
        _numbers(dataset)[dataset.column("queried")],
        run,
        dataset.fps,
    )


def situations(frames: Frames, told: Sequence[str]) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Which frames are in each situation, all of them first. One is told as an expression of
    `Frames.numbers` that `pandas.DataFrame.eval` reads, such as "distance_ahead < 20"; ValueError where
    it is no condition on what there is.
    """
    yield ALL, np.ones(len(frames.deviation), bool)
    for each in told:
        try:
            here = np.asarray(frames.numbers.eval(each, engine="python"))
        except Exception as error:  # whatever is wrong with it
            raise ValueError(
                f"{each!r}: {error}, expected a condition on {', '.join(map(str, frames.numbers))}"
            ) from None
        if here.dtype != bool or here.shape != frames.deviation.shape:
            raise ValueError(f"{each!r} is {here.dtype}, expected a condition")
        yield each, here


def quality(frames: Frames, here: NDArray[np.bool_], tau: float, cut: float) -> dict[str, Any]:
    """As `detection_quality`, of the frames where `here` [N]."""
    return detection_quality(frames.probability[here], frames.deviation[here], tau, cut)


def auroc_if_known(frames: Frames, rule: LabelRule, tau: float, error: float, seed: int) -> Any:
    """The AUROC of whoever knows the reference's action but for a normal `error`, half the range of each
    number being 1, and by how much the primary deviates from that: a bound for all who know it worse.
    """
    rng = np.random.default_rng(seed)
    halves = np.asarray(rule.half_range or np.ones(frames.actions.shape[1]))
    guessed = frames.actions + error * halves * rng.standard_normal(frames.actions.shape)
    expected = rule.deviation(frames.proposed, guessed.astype(np.float32), frames.run, frames.fps)
    ranked = 1 / (1 + expected)  # a large one is not safe
    return detection_quality(ranked, frames.deviation, tau, 0.5)["auroc"]


def _numbers(dataset: Dataset) -> pd.DataFrame:
    named: dict[str, NDArray[Any]] = {}
    for name, feature in dataset.features.items():
        numbers = feature.get("names") or []
        # those of the primary's action are called as those of the action
        if feature["shape"] == (len(numbers),) and name != "primary_action":
            named |= dict(zip(numbers, dataset.columns([name])[name].T, strict=True))
    drove = dataset.column("intervention")
    since = np.full(len(drove), np.nan)
    for start, stop in dataset.bounds:
        for row in range(start + 1, stop):
            if not drove[row]:
                since[row] = 1 / dataset.fps if drove[row - 1] else since[row - 1] + 1 / dataset.fps
    return pd.DataFrame({**named, "intervention": drove, "since_handover": since})
