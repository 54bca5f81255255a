"""Plans of short drives, and who drives them, for any test that needs one."""

from pathlib import Path
from typing import Any

import torch

from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.task import Driving
from pipeline.policies.inference import Driver
from pipeline.policies.loading import weights_sha256
from pipeline.policies.network import SafetyNetwork
from pipeline.rollout.plans import Plan
from pipeline.rollout.rules.rule import Rule


def plan(
    rule: Rule, *, track: str = "alder", seed: tuple[int, ...] = (0,), **settings: Any
) -> Plan:
    """One drive of a second on a track, among three other cars."""
    usual = {"traffic": 3, "action_repeat": 3, "seconds": 1.0}
    return Plan(Driving(tracks=track, **(usual | settings)), track, rule, seed)


def untrained(**settings: Any) -> Driver:
    """A narrow primary and its safety policy, the same at each call."""
    generator = torch.Generator().manual_seed(0)
    primary = PrimaryNetwork(2, generator=generator, **settings)
    return Driver(primary, SafetyNetwork(primary.feature_size, 4, generator=generator))


def save_untrained(primary: Path, safety: Path, seed: int = 0, **settings: Any) -> None:
    """Both as policies, the safety policy with these settings."""
    # LeRobot takes long to import
    from pipeline.driving.policy import PrimaryConfig, PrimaryPolicy
    from pipeline.policies.safety import SafetyConfig, SafetyPolicy

    generator = torch.Generator().manual_seed(seed)
    network = PrimaryNetwork(2, generator=generator)
    PrimaryPolicy(PrimaryConfig(channels=2), network).save_pretrained(primary)
    watching = SafetyNetwork(network.feature_size, 4, generator=generator)
    told = {"primary_sha256": weights_sha256(primary), "features": watching.in_features}
    SafetyPolicy(SafetyConfig(**told, hidden=4, **settings), watching).save_pretrained(safety)
