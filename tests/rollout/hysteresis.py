"""A rule of one's own, in one file, by somebody who had only docs/extending.md."""

import math

import numpy as np

from pipeline.data.schema import Asked
from pipeline.rollout.rules.rule import DROVE, NOT_ASKED, Decision, Rule, Signals


class Hysteresis(Rule):
    """The reference takes over below `cut`, until `patience` frames in a row are at least `again`;
    while the primary drives, the reference is asked with probability `audit`.
    """

    name = "hysteresis"

    def __init__(self, cut: float, again: float, patience: int, audit: float) -> None:
        if not 0 <= cut < again <= 1:  # NaN is not
            raise ValueError(f"cut is {cut} and again is {again}, expected 0 <= cut < again <= 1")
        self.cut, self.again, self.patience, self.audit = cut, again, patience, audit

    def begin(self, rng: np.random.Generator) -> None:
        self.rng, self.reference, self.good = rng, False, 0

    def decide(self, signals: Signals) -> Decision:
        safe = signals.of_policy.get("safe_probability", math.nan)
        if self.reference:
            self.good = self.good + 1 if safe >= self.again else 0
            self.reference = self.good < self.patience
        else:
            self.reference, self.good = not safe >= self.cut, 0
        if self.reference:
            return DROVE
        if self.audit == 0:
            return NOT_ASKED
        audited = self.rng.random() < self.audit
        return Decision(False, Asked.AUDIT if audited else Asked.NOT, self.audit)
