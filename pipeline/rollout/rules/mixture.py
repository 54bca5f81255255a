"""DAgger's: beta pi* + (1 - beta) pi_{i-1}, and every frame is labelled (Sec. 2.6), or a share of
them.
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.data.schema import Asked
from pipeline.rollout.rules.rule import DROVE, Decision, Rule, Signals, check_number


@dataclass
class Mixture(Rule):
    """The reference drives a frame with probability beta, else the primary; it is asked anyway, or
    about a random share of what the primary drives. ValueError where one of the two is out of its
    range.
    """

    name = "mixture"

    beta: float
    """[0, 1]"""
    ask: float = 1.0
    """[0, 1], the share"""
    _rng: np.random.Generator = field(default_factory=np.random.default_rng, compare=False)

    def __post_init__(self) -> None:
        check_number("beta", self.beta, 1.0)
        check_number("ask", self.ask, 1.0)

    def begin(self, rng: np.random.Generator) -> None:
        """Draw from this generator."""
        self._rng = rng

    def decide(self, signals: Signals) -> Decision:
        """By a draw, and by another where not all is asked about."""
        if self._rng.random() < self.beta:
            return DROVE
        asked = self.ask == 1 or self._rng.random() < self.ask
        return Decision(False, Asked.MIXTURE if asked else Asked.NOT, self.ask)
