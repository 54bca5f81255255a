"""Random valid episodes and datasets of them, for any test that needs one."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.schema import OWN, Asked, Episode
from pipeline.data.writing import write_dataset
from pipeline.driving.features import ACTIONS, CAMERA, FEATURES, IMAGE_SHAPE, ROBOT_TYPE

LABELS = {
    "tau": 0.0025,
    "measure": "steering",
    "half_range": [1.0, 0.5],
    "horizon": 0.0,
    "horizon_mode": "last",
}
JUDGED = {"cut": 0.5, "labels": LABELS}
"""What a rollout's lineage says of its safety policy; a random episode is driven with this cut."""


def write(
    path: Path,
    episodes: Iterable[Episode],
    purpose: str = "D_0",
    *,
    fps: int = 10,
    **arguments: Any,
) -> Dataset:
    """A dataset of the car's."""
    write_dataset(path, episodes, Recipe(purpose, arguments), fps=fps, robot=ROBOT_TYPE)
    return Dataset.open(path)


def random_episode(
    rng: np.random.Generator,
    frames: int,
    *,
    task: str = "coast, 20 cars",
    iteration: int = 0,
    episode: int = 0,
    first_frame: int = 0,
    reference_only: bool = False,
    asked: Sequence[int] | None = None,
    images: np.ndarray | None = None,
) -> Episode:
    """An episode of `frames` rows as the pipeline records them.

    With `reference_only` it is of iteration 0: the reference drives, and there is neither a primary
    nor a safety policy. Otherwise the reference drives where the safe probability is below 0.5, or
    was `asked` for these reasons, see `Asked`.
    `images` are drawn at random unless given, uint8 [frames, 72, 160, 3].
    """
    reference, primary = random_actions(rng, frames), random_actions(rng, frames)
    safe_probability = rng.random((frames, 1), dtype=np.float32)
    because = np.where(safe_probability < 0.5, Asked.DROVE, Asked.NOT).astype(np.int64)
    if asked is not None:
        because = np.array(asked, np.int64)[:, None]
    if reference_only:
        because = np.full((frames, 1), Asked.DROVE, np.int64)
        primary, safe_probability = (np.full_like(of, np.nan) for of in (primary, safe_probability))
    queried = because != Asked.NOT
    return Episode(
        task,
        {
            CAMERA: random_images(rng, frames) if images is None else images,
            "action": np.where(queried, reference, primary),
            "primary_action": primary,
            "affordances": rng.random((frames, 10), dtype=np.float32),
            "vehicle_state": rng.random((frames, 4), dtype=np.float32),
            "intervention": because == Asked.DROVE,
            "queried": queried,
            "safe_probability": safe_probability,
            "deviation": np.where(queried, (reference - primary)[:, :1] ** 2, np.float32(np.nan)),
            "asked_because": because,
            "ask_probability": queried.astype(np.float32),
            "source.dataset": np.full((frames, 1), OWN, np.int64),
            "source.iteration": np.full((frames, 1), iteration, np.int64),
            "source.episode": np.full((frames, 1), episode, np.int64),
            "source.frame": np.arange(first_frame, first_frame + frames, dtype=np.int64)[:, None],
        },
        FEATURES,
    )


def random_actions(rng: np.random.Generator, frames: int) -> np.ndarray:
    """float32 [frames, 2]: steering in [-1, 1], brake 0 or 1."""
    actions = np.empty((frames, len(ACTIONS)), np.float32)
    actions[:, 0] = rng.uniform(-1, 1, frames)
    actions[:, 1] = rng.integers(0, 2, frames)
    return actions


def random_images(rng: np.random.Generator, frames: int) -> np.ndarray:
    """uint8 [frames, 72, 160, 3]: coarse blocks, which compress about as well as a road does."""
    height, width, channels = IMAGE_SHAPE
    blocks = rng.integers(0, 256, (frames, height // 4, width // 4, channels), dtype=np.uint8)
    return blocks.repeat(4, axis=1).repeat(4, axis=2)
