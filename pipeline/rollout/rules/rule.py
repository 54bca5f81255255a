"""The seam to the method."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.schema import Asked


def check_number(name: str, value: float, highest: float = np.inf) -> None:
    """Raise a ValueError unless `value` is from 0 to `highest`."""
    if not 0 <= value <= highest:
        raise ValueError(f"{name} is {value}, expected a number from 0 to {highest:g}")


@dataclass(frozen=True)
class Signals:
    """What is known when a frame is to be driven."""

    primary_action: NDArray[np.float32]
    """[A], NaN without a primary"""
    of_policy: Mapping[str, float]
    """what the policies say beside the action, by name: "safe_probability", say"""
    reference_action: NDArray[np.float32]
    """[A], NaN but for a rule that `looks_up`"""


@dataclass(frozen=True)
class Decision:
    """Who drives a frame, and whether it costs a query; ValueError where the reference is to drive unasked,
    or the probability is none.
    """

    reference_drives: bool
    asked: Asked
    """why the reference is asked, `Asked.NOT` if it is not; it drives only where it is asked"""
    ask_probability: float
    """[0, 1], with which it was to be asked here: 1 or 0 unless that was left to chance"""

    def __post_init__(self) -> None:
        if self.reference_drives and self.asked is Asked.NOT:
            raise ValueError("asked is NOT where the reference drives, expected a reason")
        check_number("ask_probability", self.ask_probability, 1.0)


DROVE = Decision(True, Asked.DROVE, 1.0)
NOT_ASKED = Decision(False, Asked.NOT, 0.0)


class Rule(ABC):
    """Decides frame by frame. It may remember what it likes of one drive."""

    name: str
    looks_up: bool = False
    """whether it must see the reference's action before it decides: that is no rule to live by, but
    one to compare with, and counted apart"""

    def begin(self, rng: np.random.Generator) -> None:  # noqa: B027 (most rules have no memory)
        """A new drive; `rng` is the rule's own."""

    @abstractmethod
    def decide(self, signals: Signals) -> Decision:
        """Who drives the next frame, and who is asked."""
