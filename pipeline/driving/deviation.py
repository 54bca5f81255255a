"""Epsilon (Sec. 3.1) of the car: how far a primary is from the reference. N is the number of frames.

Actions are float32 [N, 2], steering and brake, whose ranges are known; all raise a ValueError for
other shapes.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.policies.measures import check_actions


def steering(
    proposed: NDArray, reference: NDArray, half_range: NDArray | None = None
) -> NDArray[np.float64]:
    """[N], the squared difference of the steering, in [0, 4]: the paper's."""
    return _squares(proposed, reference)[:, 0]


def steering_and_brake(
    proposed: NDArray, reference: NDArray, half_range: NDArray | None = None
) -> NDArray[np.float64]:
    """[N], with the brake's, 0 or 1: a wrong brake is unsafe under any threshold below 1."""
    return _squares(proposed, reference).sum(1)


def _squares(proposed: NDArray, reference: NDArray) -> NDArray[np.float64]:
    check_actions(proposed, reference, 2)
    # the difference is rounded as the actions are, the square is not
    return np.square((proposed - reference).astype(np.float64))
