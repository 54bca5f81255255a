"""The rule of a drive that a saved safety policy watches."""

from pathlib import Path

from pipeline.policies.loading import read_cut, read_labels
from pipeline.rollout.strategies import Rule, Strategy


def driving_rule(safety: Path, strategy: Strategy, cut: float | None = None) -> Rule:
    """The rule of a driving strategy for a primary that the policy in `safety` watches.

    What deviates, for OPTIMAL, is what the policy's labels were made by.

    Args:
        safety: its directory.
        strategy: one that needs a primary.
        cut: in the place of the policy's own.

    Raises:
        ValueError: as `read_config`; `cut` is out of its range.
    """
    labels = read_labels(safety)
    return Rule(
        strategy,
        cut=read_cut(safety) if cut is None else cut,
        tau=labels["tau"],
        include_brake=labels["include_brake"],
    )
