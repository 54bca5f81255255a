"""DAgger's: beta pi* + (1 - beta) pi_{i-1}, and every frame is labelled (Sec. 2.6)."""

from dataclasses import dataclass, field

import numpy as np

from pipeline.data.schema import Asked
from pipeline.rollout.rules.rule import DROVE, Decision, Rule, Signals, check_number


@dataclass
class Mixture(Rule):
    """The reference drives a frame with probability beta, else the primary; it is asked anyway.
    ValueError where beta is out of its range.
    """

    name = "mixture"

    beta: float
    """[0, 1]"""
    _rng: np.random.Generator = field(default_factory=np.random.default_rng, compare=False)

    def __post_init__(self) -> None:
        check_number("beta", self.beta, 1.0)

    def begin(self, rng: np.random.Generator) -> None:
        """Draw from this generator."""
        self._rng = rng

    def decide(self, signals: Signals) -> Decision:
        """By a draw."""
        return DROVE if self._rng.random() < self.beta else Decision(False, Asked.MIXTURE, 1.0)
