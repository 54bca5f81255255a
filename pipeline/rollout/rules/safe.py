"""The safe strategy: the primary drives where the safety policy says 1, else the reference
(Sec. 3.1).
"""

import math
from dataclasses import dataclass

from pipeline.rollout.rules.rule import DROVE, NOT_ASKED, Decision, Rule, Signals, check_number


@dataclass(frozen=True)
class Safe(Rule):
    """The reference drives where the safe probability is not at least the cut; ValueError where that is
    out of its range.
    """

    name = "safe"

    cut: float
    """[0, 1]"""

    def __post_init__(self) -> None:
        check_number("cut", self.cut, 1.0)

    def decide(self, signals: Signals) -> Decision:
        """By pi_safe's probability; NaN is never safe."""
        safe = signals.of_policy.get("safe_probability", math.nan) >= self.cut
        return NOT_ASKED if safe else DROVE
