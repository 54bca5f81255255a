"""The primary always drives (Sec. 2.5)."""

from dataclasses import dataclass

from pipeline.rollout.rules.rule import NOT_ASKED, Decision, Rule, Signals


@dataclass(frozen=True)
class Naive(Rule):
    """The primary always drives, and nobody is asked."""

    name = "naive"

    def decide(self, signals: Signals) -> Decision:
        """It does."""
        return NOT_ASKED
