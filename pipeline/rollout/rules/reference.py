"""The reference always drives: how D_0 and D_safe are collected (Algorithm 1, lines 1 and 2)."""

from dataclasses import dataclass

from pipeline.rollout.rules.rule import DROVE, Decision, Rule, Signals


@dataclass(frozen=True)
class Reference(Rule):
    """The reference always drives."""

    name = "reference"

    def decide(self, signals: Signals) -> Decision:
        """It does."""
        return DROVE
