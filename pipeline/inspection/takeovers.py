"""Takeovers: where the reference took the wheel because the safety policy said unsafe.

In the shapes, N is the number of rows of a dataset.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.pieces import runs

BEFORE, AFTER = 2.0, 1.0  # [s] of a window around its takeover


@dataclass(frozen=True)
class Takeover:
    """Successive frames of one episode that the reference drove, and a window around them."""

    episode: int
    start: int
    """The first frame that the reference drove, counted within the episode."""
    stop: int
    """The frame after the last one that it drove."""
    first: int
    """The first frame of the window: 2 s before the takeover, or where the episode begins."""
    end: int
    """The frame after the window's last: 1 s after the takeover, or where the episode ends."""
    safe_probability: float
    """The lowest in the takeover: how unsafe it was."""


def takeovers(
    intervention: NDArray[np.bool_],
    safe_probability: NDArray[np.floating],
    episode_index: NDArray[np.int64],
    *,
    fps: int,
) -> list[Takeover]:
    """All takeovers, most unsafe first, equally unsafe ones in the order of the dataset.

    What the reference drove without a safety policy is no takeover.

    Args:
        intervention: [N].
        safe_probability: [N], NaN where there is none.
        episode_index: [N], never falling.
        fps: frames per second.
    """
    found: list[Takeover] = []
    taken = intervention & ~np.isnan(safe_probability)
    for episode in np.unique(episode_index):
        rows = episode_index == episode
        found += _of_episode(int(episode), taken[rows], safe_probability[rows], fps)
    return sorted(found, key=lambda takeover: takeover.safe_probability)


def _of_episode(
    episode: int, taken: NDArray[np.bool_], safe_probability: NDArray[np.floating], fps: int
) -> list[Takeover]:
    return [
        Takeover(
            episode,
            run.start,
            run.stop,
            max(run.start - round(BEFORE * fps), 0),
            min(run.stop + round(AFTER * fps), len(taken)),
            float(safe_probability[run].min()),
        )
        for run in runs(taken)
    ]
