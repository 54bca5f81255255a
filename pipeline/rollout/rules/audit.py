"""A rule whose primary is audited: in a random share of its frames the reference is asked, too."""

from dataclasses import dataclass, field

import numpy as np

from pipeline.data.schema import Asked
from pipeline.rollout.rules.rule import Decision, Rule, Signals, check_number


@dataclass
class Audit(Rule):
    """Another rule, with a query for a random share of the frames that it asks nothing about.

    Whatever a safety policy says: only so is it known, where the reference is a person, what it
    misses. Who drives does not change. ValueError where the share is out of its range.
    """

    rule: Rule
    share: float
    """[0, 1]"""
    _rng: np.random.Generator = field(default_factory=np.random.default_rng, compare=False)

    def __post_init__(self) -> None:
        check_number("audit", self.share, 1.0)
        self.name, self.looks_up = self.rule.name, self.rule.looks_up

    def begin(self, rng: np.random.Generator) -> None:
        """Draw from a generator of its own, so that the other rule draws what it would alone."""
        (self._rng,) = rng.spawn(1)
        self.rule.begin(rng)

    def decide(self, signals: Signals) -> Decision:
        """The other rule's decision, with a draw where the primary drives unasked."""
        decision = self.rule.decide(signals)
        if decision.asked is not Asked.NOT:
            return decision
        audited = self._rng.random() < self.share
        return Decision(False, Asked.AUDIT if audited else Asked.NOT, self.share)
