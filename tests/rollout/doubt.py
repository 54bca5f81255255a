"""A rule of one's own, in one file, by somebody who had only docs/extending.md."""

import math

import numpy as np

from pipeline.data.schema import Asked
from pipeline.rollout.rules.rule import DROVE, Decision, Rule, Signals


class Doubt(Rule):
    """The less a frame looks safe the likelier the reference is asked about it; and once `patience`
    frames of a drive have looked rather unsafe, it drives the rest of it.
    """

    name = "doubt"

    def __init__(self, patience: int) -> None:
        if patience < 1:
            raise ValueError(f"patience is {patience}, expected at least 1")
        self.patience = patience

    def begin(self, rng: np.random.Generator) -> None:
        self.rng, self.left = rng, self.patience

    def decide(self, signals: Signals) -> Decision:
        safe = signals.of_policy.get("safe_probability", math.nan)
        self.left -= not safe >= 0.5  # NaN is not
        if self.left <= 0:
            return DROVE
        doubt = 1.0 if math.isnan(safe) else 1 - safe
        asked = self.rng.random() < doubt
        return Decision(False, Asked.AUDIT if asked else Asked.NOT, doubt)
