"""By what numbers the frames of a rollout were, and are, called unsafe. N is the number of frames."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from pipeline.data.lineage import Lineage, first_bits
from pipeline.policies.measures import deviation
from pipeline.rollout.rules.calm import Calm
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.optimal import Optimal
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import Strategy


@dataclass(frozen=True)
class Judgement:
    """The cut that is driven with, and what the safety policy's labels call unsafe."""

    cut: float
    """[0, 1]: a `safe_probability` below it is unsafe"""
    tau: float
    """>= 0: a deviation above it is"""
    measure: str
    """what deviates: a name of `registry.MEASURES`"""
    half_range: tuple[float, ...] = ()
    """of each number of an action; none: 1 for each"""

    @classmethod
    def of(cls, labels: Mapping[str, Any], cut: float) -> Self:
        """From what a safety policy's configuration says of its labels."""
        return cls(cut, labels["tau"], labels["measure"], tuple(labels["half_range"]))

    @classmethod
    def read(cls, safety: Path, cut: float | None = None) -> Self:
        """Of the safety policy in a directory, ValueError where there is none; `cut` takes the place of its
        own.
        """
        from pipeline.policies.loading import read_cut, read_labels  # imports PyTorch

        return cls.of(read_labels(safety), read_cut(safety) if cut is None else cut)

    @property
    def words(self) -> str:
        """What deviates."""
        return self.measure.replace("-", " ")

    def deviation(self, proposed: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Epsilon [N] as the labels know it; NaN where either action [N, A] is."""
        return deviation(self.measure, proposed, reference, self.half_range)


def rule_of(
    strategy: Strategy,
    judgement: Judgement | None,
    *,
    resume: float | None = None,
    least: float = 0,
) -> Rule:
    """The rule of a driving strategy, but for `MIXTURE`; the judgement is None where there is no safety
    policy. Of the safe strategy, `resume` and `least` are as of `Calm`, the cut and 0 unless given.

    ValueError where the strategy needs a safety policy, or a number that no policy has, beta; or a number
    is out of its range.
    """
    match strategy:
        case Strategy.REFERENCE:
            return Reference()
        case Strategy.NAIVE:
            return Naive()
        case Strategy.MIXTURE:
            raise ValueError(f"strategy is {strategy}, expected one that goes by no beta")
    if judgement is None:
        raise ValueError(f"strategy is {strategy}, which needs a safety policy")
    match strategy:
        case Strategy.SAFE:
            cut = judgement.cut
            if resume is not None and not resume >= cut:
                raise ValueError(f"resume is {resume}, expected at least the cut, {cut:g}")
            return Calm(Safe(cut), cut if resume is None else resume, least)
        case Strategy.OPTIMAL:
            return Optimal(judgement.tau, judgement.deviation)


def judgements(lineage: Lineage) -> dict[int, Judgement]:
    """Of each rollout by a safety policy that a dataset is or comes from, by `source.dataset`."""
    return {
        first_bits(sha256): Judgement.of(made.arguments["labels"], made.arguments["cut"])
        for sha256, made in lineage.made.items()
        if "labels" in made.arguments
    }
