"""The optimal safety policy of Eq. 2, which knows the deviation: what a learned one can hope for."""

from collections.abc import Callable
from dataclasses import dataclass

from numpy.typing import NDArray

from pipeline.rollout.rules.rule import DROVE, NOT_ASKED, Decision, Rule, Signals, check_number


@dataclass(frozen=True)
class Optimal(Rule):
    """The reference drives where the primary deviates from it by more than tau; ValueError where that
    is out of its range.
    """

    name = "optimal"
    looks_up = True

    tau: float
    """>= 0"""
    deviation: Callable[[NDArray, NDArray], NDArray]
    """epsilon [N] of actions [N, A], as the labels of a safety policy know it"""

    def __post_init__(self) -> None:
        check_number("tau", self.tau)

    def decide(self, signals: Signals) -> Decision:
        """By the deviation; without a primary there is none to trust."""
        epsilon = self.deviation(signals.primary_action[None], signals.reference_action[None])[0]
        return NOT_ASKED if epsilon <= self.tau else DROVE
