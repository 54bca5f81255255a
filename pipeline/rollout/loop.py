"""The closed loop: a rule decides frame by frame who drives an environment, and who is asked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.data.schema import Asked
from pipeline.environment import Action, Environment, columns_of
from pipeline.rollout.rules.rule import Decision, Rule, Signals

if TYPE_CHECKING:
    from pipeline.policies.inference import Driver


@dataclass(frozen=True)
class Frame:
    """What was seen, proposed and decided at one moment, and what came of it."""

    observation: Mapping[str, NDArray]
    """by column, as datasets have it"""
    hidden: Mapping[str, NDArray]
    """by column, what no policy sees"""
    primary_action: Action
    """[A], NaN without a primary"""
    reference_action: Action
    """[A], NaN unless it was asked or, to measure, looked up: whoever uses it must count it"""
    safe_probability: float
    """[0, 1], NaN without a safety policy"""
    decision: Decision
    """who drove, and whether the reference was asked"""
    outcome: Mapping[str, float]
    """what the drive had come to when the frame was over"""
    ended: str | None
    """why the drive was over with it; None where it went on"""
    failed: bool
    """whether somebody then had to put the robot back"""

    @property
    def intervention(self) -> bool:
        """Whether the reference drove."""
        return self.decision.reference_drives


def drive(
    env: Environment,
    driver: Driver | None,
    rule: Rule,
    *,
    seed: int,
    rng: np.random.Generator,
    can_look_up: bool,
    measure: bool,
) -> Iterator[Frame]:
    """Drive once, until the environment says that it is over; ValueError where the primary's action is NaN
    or infinite.

    Args:
        env: is reset with `seed`, and left open. Each call of its `label` is a query.
        driver: the policies; None where only the reference drives. It is reset when the drive begins,
            and after each frame in which the reference drove: what it planned before is of no use.
        rule: who drives; `rng` is its own.
        can_look_up: whether the reference may be looked up, which costs nothing; a ValueError where not,
            and the rule looks up.
        measure: whether it is looked up in every frame about which it is not asked.
    """
    if rule.looks_up and not can_look_up:
        raise ValueError(
            f"{rule.name} looks up the reference, which cannot be in this task, expected another rule"
        )
    rule.begin(rng)
    if driver is not None:
        driver.reset()
    observation, info = env.reset(seed=seed)
    unknown = np.full(env.action_space.shape or (), np.nan, np.float32)
    over = False
    while not over:
        seen = columns_of(observation)
        primary_action, signals = _consult(driver, seen, unknown)
        known = env.look_up() if rule.looks_up else unknown
        decision = rule.decide(Signals(primary_action, signals, known))
        if decision.asked is not Asked.NOT:
            known = env.label()
        elif measure and can_look_up and not rule.looks_up:
            known = env.look_up()
        hidden = info["hidden"]
        action = known if decision.reference_drives else primary_action
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        if driver is not None and decision.reference_drives:
            driver.reset()
        yield Frame(
            seen,
            hidden,
            primary_action,
            known,
            signals.get("safe_probability", np.nan),
            decision,
            env.outcome(),
            info["ended"],
            info["failed"],
        )


def _consult(
    driver: Driver | None, seen: Mapping[str, NDArray], unknown: Action
) -> tuple[Action, dict[str, Any]]:
    """The primary's action and what the policies say beside it; NaN where there is no primary."""
    if driver is None:
        return unknown, {}
    action, signals = driver.act(seen)
    if not np.isfinite(action).all():
        raise ValueError(f"the primary's action is {action}, expected finite numbers")
    return action, signals
