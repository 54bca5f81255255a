"""Plans of short drives, for any test that needs one."""

from typing import Any

from pipeline.driving.task import Driving
from pipeline.rollout.plans import Plan
from pipeline.rollout.rules.rule import Rule


def plan(
    rule: Rule, *, track: str = "alder", seed: tuple[int, ...] = (0,), **settings: Any
) -> Plan:
    """One drive of a second on a track, among three other cars."""
    usual = {"traffic": 3, "action_repeat": 3, "seconds": 1.0}
    return Plan(Driving(tracks=track, **(usual | settings)), track, rule, seed)
