"""Takeovers: where the reference took the wheel because the safety policy said unsafe.

In the shapes, N is the number of rows of a dataset.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.pieces import runs

JUDGED = ("intervention", "queried", "safe_probability", "deviation")
"""The columns that tell of takeovers."""
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
    deviation: float
    """The highest in the takeover; NaN where it is not known."""
    queries: int
    """What it cost."""

    def __str__(self) -> str:
        return (
            f"episode {self.episode}, frames {self.start} to {self.stop - 1}: safe probability "
            f"{self.safe_probability:.3f}, deviation {self.deviation:.4f}, {self.queries} queries"
        )


def takeovers(
    columns: Mapping[str, NDArray], episode_index: NDArray[np.int64], *, fps: int
) -> list[Takeover]:
    """All takeovers, most unsafe first, equally unsafe ones in the order of the dataset.

    What the reference drove without a safety policy is no takeover. `columns` are those of JUDGED,
    each [N]; `episode_index`, [N], never falls.
    """
    found: list[Takeover] = []
    for episode in np.unique(episode_index):
        rows = {name: columns[name][episode_index == episode] for name in JUDGED}
        taken = rows["intervention"] & ~np.isnan(rows["safe_probability"])
        found += [
            Takeover(
                int(episode),
                run.start,
                run.stop,
                max(run.start - round(BEFORE * fps), 0),
                min(run.stop + round(AFTER * fps), len(taken)),
                float(rows["safe_probability"][run].min()),
                float(rows["deviation"][run].max()),
                int(rows["queried"][run].sum()),
            )
            for run in runs(taken)
        ]
    return sorted(found, key=lambda takeover: takeover.safe_probability)
