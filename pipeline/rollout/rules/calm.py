"""A rule whose calls last: fewer handovers, for whoever has to take over."""

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.rollout.rules.rule import DROVE, Decision, Rule, Signals, check_number


@dataclass
class Calm(Rule):
    """Another rule, but that the reference, once it drives, hands back later.

    That is when the other rule lets the primary drive, the safe probability is at least `resume`, and
    the reference has driven for `least` frames. ValueError where a number is out of its range.
    """

    rule: Rule
    resume: float
    """[0, 1]; above the cut of the other rule this is hysteresis"""
    least: float
    """>= 0 frames, to the nearest"""
    _driven: int = field(default=0, compare=False)

    def __post_init__(self) -> None:
        check_number("resume", self.resume, 1.0)
        check_number("least", self.least)
        self.name, self.looks_up = self.rule.name, self.rule.looks_up

    def begin(self, rng: np.random.Generator) -> None:
        """The primary begins, if it may."""
        self._driven = 0
        self.rule.begin(rng)

    def decide(self, signals: Signals) -> Decision:
        """The other rule's decision, unless the reference is to keep driving."""
        decision = self.rule.decide(signals)
        safe = signals.of_policy.get("safe_probability", math.nan) >= self.resume
        keeps = self._driven > 0 and not (safe and self._driven > self.least - 0.5)
        if not (decision.reference_drives or keeps):
            self._driven = 0
            return decision
        self._driven += 1
        return decision if decision.reference_drives else DROVE
