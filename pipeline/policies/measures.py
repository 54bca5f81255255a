"""Epsilon (Sec. 3.1): how far a primary is from the reference. N frames, A numbers in an action."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.data.schema import Feature
from pipeline.registry import MEASURES, find

Measure = Callable[[NDArray, NDArray, NDArray], NDArray]
"""Of proposed and reference actions float32 [N, A], and half the range of each of their numbers
float64 [A]: epsilon [N], NaN where either is."""


def mean_square(proposed: NDArray, reference: NDArray, half_range: NDArray) -> NDArray[np.float64]:
    """The mean over the numbers of an action of their squared differences, each of which is measured by
    half the range of that number: from end to end is 4. ValueError where shapes differ.
    """
    check_actions(proposed, reference, len(half_range))
    return np.square((proposed.astype(np.float64) - reference) / half_range).mean(axis=1)


def half_range(action: Feature) -> list[float]:
    """Half the range of each number of an action: 1 where its feature has no "low" and "high"."""
    numbers = action["shape"][0]
    low, high = (action.get(end) or [value] * numbers for end, value in (("low", -1), ("high", 1)))
    return [(top - bottom) / 2 for bottom, top in zip(low, high, strict=True)]


def check_actions(proposed: NDArray, reference: NDArray, numbers: int) -> None:
    """Raise a ValueError unless both are [N, A] of the same N, and A is `numbers`."""
    if proposed.shape != reference.shape or proposed.shape[1:] != (numbers,):
        raise ValueError(
            f"proposed is {proposed.shape} and reference {reference.shape}, "
            f"expected the same (frames, {numbers})"
        )


def deviation(
    measure: str, proposed: NDArray, reference: NDArray, half_range: Sequence[float]
) -> NDArray[np.float64]:
    """Epsilon [N] of actions float32 [N, A] by the measure of this name: one of MEASURES, or
    "module:function". `half_range` is of each number of an action; none: 1 for each. ValueError where
    there is no such measure, or as the measure.
    """
    found: Measure = find("measure", measure, MEASURES)
    halves = np.asarray(half_range or np.ones(proposed.shape[-1]), np.float64)
    return found(proposed, reference, halves)
