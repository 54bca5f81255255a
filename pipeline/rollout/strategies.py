"""Driving strategies (Sec. 2.5 and 3.1) by name."""

from __future__ import annotations

from enum import StrEnum


class Strategy(StrEnum):
    """How the driver is chosen; each is a rule in `rollout/rules`."""

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


DRIVING = (Strategy.NAIVE, Strategy.SAFE, Strategy.OPTIMAL)
"""The strategies that a trained primary is evaluated with."""


def parse_driving(name: str) -> Strategy:
    """The strategy of DRIVING with this name; ValueError where there is none."""
    if name not in DRIVING:
        raise ValueError(f"strategy {name!r}: expected one of {', '.join(DRIVING)}")
    return Strategy(name)
