"""By what numbers the frames of a rollout were, and are, called unsafe. N is the number of frames."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from pipeline.data.lineage import Lineage, first_bits
from pipeline.driving.deviation import deviation
from pipeline.rollout.strategies import Rule


@dataclass(frozen=True)
class Judgement:
    """The cut that a rollout was driven with, and what its safety policy's labels call unsafe."""

    cut: float
    """[0, 1]: a `safe_probability` below it is unsafe"""
    tau: float
    """>= 0: a deviation above it is"""
    include_brake: bool
    """whether a wrong brake is a deviation, too"""

    @classmethod
    def of(cls, labels: Mapping[str, Any], cut: float) -> Self:
        """From what a safety policy's configuration says of its labels."""
        return cls(cut, labels["tau"], labels["include_brake"])

    @classmethod
    def of_rule(cls, rule: Rule) -> Self:
        """From what a drive goes by that a safety policy watches."""
        return cls(rule.cut, rule.tau, rule.include_brake)

    @property
    def measure(self) -> str:
        """What deviates, in words."""
        return "steering and brake" if self.include_brake else "steering"

    def deviation(self, proposed: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Epsilon float32 [N] as the labels know it; NaN where either action [N, 2] is."""
        return deviation(proposed, reference, include_brake=self.include_brake)


def judgements(lineage: Lineage) -> dict[int, Judgement]:
    """Of each rollout by a safety policy that a dataset is or comes from, by `source.dataset`."""
    return {
        first_bits(sha256): Judgement.of(made.arguments["labels"], made.arguments["cut"])
        for sha256, made in lineage.made.items()
        if "labels" in made.arguments
    }
