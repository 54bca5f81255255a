"""Driving strategies (Sec. 3.1): who drives."""

from __future__ import annotations

from enum import StrEnum


class Strategy(StrEnum):
    """How the driver is chosen."""

    REFERENCE = "reference"
    """the reference policy always drives"""
    NAIVE = "naive"
    """the primary policy always drives"""
    SAFE = "safe"
    """the primary drives where the safety policy says 1, else the reference"""


def reference_drives(strategy: Strategy, safe_probability: float, cut: float) -> bool:
    """Whether the reference drives; `safe_probability` is pi_safe's, below `cut` the state counts
    as unsafe.
    """
    return strategy is Strategy.REFERENCE or (strategy is Strategy.SAFE and safe_probability < cut)
