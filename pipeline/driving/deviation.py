"""Epsilon (Sec. 3.1): how far a primary is from the reference. N is the number of frames."""

import numpy as np


def deviation(
    proposed: np.ndarray, reference: np.ndarray, *, include_brake: bool = False
) -> np.ndarray:
    """Epsilon float32 [N], the squared difference of the steering, in [0, 4].

    Args:
        proposed: float32 [N, 2], the primary's steering and brake.
        reference: float32 [N, 2], the reference's for the same frames.
        include_brake: whether the brake's squared difference, 0 or 1, is added: then a wrong brake
            is unsafe under any threshold below 1.

    Raises:
        ValueError: arrays of other shapes.
    """
    if proposed.shape != reference.shape or proposed.shape != (len(proposed), 2):
        raise ValueError(
            f"proposed is {proposed.shape} and reference {reference.shape}, "
            "expected the same (frames, 2)"
        )
    squares = np.square(proposed.astype(np.float32) - reference.astype(np.float32))
    return squares.sum(1) if include_brake else squares[:, 0]
