"""Driving strategies (Sec. 2.5 and 3.1): who drives."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Strategy(StrEnum):
    """How the driver is chosen."""

    REFERENCE = "reference"
    """the reference policy always drives"""
    NAIVE = "naive"
    """the primary policy always drives"""
    SAFE = "safe"
    """the primary drives where the safety policy says 1, else the reference"""
    OPTIMAL = "optimal"
    """the safe strategy with the optimal safety policy of Eq. 2, which knows the deviation"""
    MIXTURE = "mixture"
    """DAgger's: the reference drives with probability beta, else the primary"""


@dataclass(frozen=True)
class Rule:
    """A strategy and the number that it goes by; the others do not matter to it.

    Raises:
        ValueError: a number is out of its range.
    """

    strategy: Strategy
    cut: float = 0.5
    """for SAFE, [0, 1]: a safe probability that is not at least this is unsafe"""
    tau: float = 0.0
    """for OPTIMAL, >= 0: a deviation above it is unsafe"""
    include_brake: bool = False
    """for OPTIMAL: whether a wrong brake is a deviation too"""
    beta: float = 0.0
    """for MIXTURE, [0, 1]: the probability that the reference drives"""

    def __post_init__(self) -> None:
        for name, highest in (("cut", 1.0), ("tau", float("inf")), ("beta", 1.0)):
            if not 0 <= getattr(self, name) <= highest:
                raise ValueError(
                    f"{name} is {getattr(self, name)}, expected a number from 0 to {highest:g}"
                )

    def reference_drives(self, safe_probability: float, deviation: float, draw: float) -> bool:
        """Whether the reference drives.

        Args:
            safe_probability: [0, 1], pi_safe's; NaN is never safe.
            deviation: epsilon, >= 0; NaN where there is no primary.
            draw: a random number in [0, 1).
        """
        match self.strategy:
            case Strategy.REFERENCE:
                return True
            case Strategy.NAIVE:
                return False
            case Strategy.SAFE:
                return not safe_probability >= self.cut
            case Strategy.OPTIMAL:
                return deviation > self.tau
            case Strategy.MIXTURE:
                return draw < self.beta


DRIVING = (Strategy.NAIVE, Strategy.SAFE, Strategy.OPTIMAL)
"""The strategies that a trained primary is evaluated with."""


def parse_driving(name: str) -> Strategy:
    """The strategy of DRIVING with this name.

    Raises:
        ValueError: there is none.
    """
    if name not in DRIVING:
        raise ValueError(f"strategy {name!r}: expected one of {', '.join(DRIVING)}")
    return Strategy(name)
