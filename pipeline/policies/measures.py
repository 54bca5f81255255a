"""Epsilon (Sec. 3.1): how far a primary is from the reference. N frames, A numbers in an action."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pipeline.registry import MEASURES, find

Measure = Callable[[NDArray, NDArray], NDArray]
"""Of proposed and reference actions float32 [N, A]: epsilon float32 [N], NaN where either is."""


def mean_square(proposed: NDArray, reference: NDArray) -> NDArray[np.float32]:
    """The mean over the numbers of an action of their squared differences.

    Raises:
        ValueError: arrays of other shapes.
    """
    check_actions(proposed, reference)
    return np.square(proposed.astype(np.float32) - reference.astype(np.float32)).mean(axis=1)


def check_actions(proposed: NDArray, reference: NDArray, numbers: int | None = None) -> None:
    """Raise a ValueError unless both are [N, A] of the same N and A, and A is `numbers`, if given."""
    fits = proposed.ndim == 2 and numbers in (None, proposed.shape[-1])
    if proposed.shape != reference.shape or not fits:
        raise ValueError(
            f"proposed is {proposed.shape} and reference {reference.shape}, "
            f"expected the same (frames, {numbers or 'numbers of an action'})"
        )


def load_measure(name: str) -> Measure:
    """The measure of this name: one of MEASURES, or "module:function".

    Raises:
        ValueError: there is none.
    """
    found: Measure = find("measure", name, MEASURES)
    return found
