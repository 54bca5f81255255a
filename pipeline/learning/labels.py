"""What the safety policy learns: which deviations count as safe (Eq. 2), and how far ahead.

In the shapes, N is the number of frames.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np

from pipeline.policies.measures import deviation


@dataclass(frozen=True)
class LabelRule:
    """What of a drive is held against a primary: the deviation that Eq. 2 compares with tau."""

    measure: str
    """what deviates: a name of `registry.MEASURES`"""
    horizon: float
    """>= 0 [s], how far ahead the deviation is looked for"""
    mode: Literal["last", "max"]
    """see `label_horizon`"""
    half_range: Sequence[float] = ()
    """of each number of an action; none: 1 for each"""

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Self:
        """The rule that a safety policy's configuration carries."""
        return cls(*(config[each] for each in ("measure", "horizon", "horizon_mode", "half_range")))

    def deviation(
        self, proposed: np.ndarray, reference: np.ndarray, episode_index: np.ndarray, fps: float
    ) -> np.ndarray:
        """[N], what labels each frame of `proposed` and `reference` [N, A], `fps` frames a second. Raises
        as `deviation` and `label_horizon`.
        """
        epsilon = deviation(self.measure, proposed, reference, self.half_range)
        return label_horizon(epsilon, episode_index, round(self.horizon * fps), self.mode)


def safe_labels(deviation: np.ndarray, tau: float) -> np.ndarray:
    """Eq. 2, bool [N]: True, safe, where `deviation` [N] is at most `tau`; ValueError where it is NaN, which
    is neither safe nor unsafe.
    """
    unknown = int(np.isnan(deviation).sum())
    if unknown:
        raise ValueError(f"deviation is NaN in {unknown} of {len(deviation)} frames, expected none")
    return deviation <= tau


def threshold_for_share(deviation: np.ndarray, share: float) -> float:
    """The smallest tau under which at least `share` of the frames are safe, the paper's 0.777 say; of
    deviations [N] without NaN. ValueError where there are no frames, or the share is outside (0, 1].
    """
    if not 0 < share <= 1 or len(deviation) == 0:
        raise ValueError(
            f"share is {share} of {len(deviation)} frames, expected a share in (0, 1] of some"
        )
    # Less a hair: 0.777 * 1000 is a little more than 777 in floating point.
    position = math.ceil(share * len(deviation) - 1e-9) - 1
    return float(np.sort(deviation)[position])


def label_horizon(
    deviation: np.ndarray,
    episode_index: np.ndarray,
    horizon_frames: int,
    mode: Literal["last", "max"],
) -> np.ndarray:
    """The deviation that labels each frame when unsafety is to be foreseen, [N], of `deviation` [N] in the
    episodes `episode_index` int [N]; with a horizon of 0 it is the same.

    `last` is the deviation `horizon_frames` later, `max` the largest from the frame itself until
    then. The future ends with the episode: beyond it, its last frame stands for what would follow.
    ValueError for a horizon below 0, another mode, or rows of an episode that are not together.
    """
    if horizon_frames < 0 or mode not in ("last", "max"):
        raise ValueError(
            f"horizon_frames is {horizon_frames} and mode {mode!r}, "
            "expected at least 0 and 'last' or 'max'"
        )
    last = np.append(np.flatnonzero(np.diff(episode_index)), len(episode_index) - 1)
    if len(last) > len(np.unique(episode_index)) > 0:
        raise ValueError("episode_index has an episode in pieces, expected its rows together")
    rows = np.arange(len(deviation))
    ends = last[np.searchsorted(last, rows)]
    if mode == "last":
        return deviation[np.minimum(rows + horizon_frames, ends)]
    label = deviation.copy()
    for ahead in range(1, horizon_frames + 1):
        label = np.maximum(label, deviation[np.minimum(rows + ahead, ends)])
    return label
