"""What is to be driven. Every drive has a random generator of its own, so their order does not
matter.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.environment import Environment
from pipeline.rollout.loop import Frame, drive
from pipeline.rollout.rules.rule import Rule
from pipeline.task import Task

if TYPE_CHECKING:
    from pipeline.policies.inference import Driver

_STREAMS = {
    "D_0": 0,
    "D_safe": 1,
    "D_held": 2,
    "supervised": 10,
    "rollout": 100,
    "evaluation": 1000,
    "film": 2000,
}
"""The second number of every drive's seed: no two collections of an experiment meet the same random
numbers.
"""
_RULE = 1  # the last number of the seed of a rule's own generator


def stream(purpose: str, iteration: int = 0) -> int:
    """The stream of a purpose in an iteration; ValueError where that would be another purpose's."""
    first = _STREAMS[purpose]
    room = min((other for other in _STREAMS.values() if other > first), default=2**32) - first
    if iteration >= room:
        raise ValueError(
            f"iteration is {iteration} of {purpose!r}, expected at most {room - 1}: "
            "its drives would be those of another purpose"
        )
    return first + iteration


@dataclass(frozen=True)
class Plan:
    """One drive."""

    task: Task
    scenario: str
    """one of the task's"""
    rule: Rule
    """who drives"""
    seed: tuple[int, ...]
    """of the drive: up to four numbers below 2**32"""

    @property
    def description(self) -> str:
        """The scenario in words, as datasets carry it."""
        return self.task.describe(self.scenario)


def driven(
    plan: Plan, driver: Driver | None, *, measure: bool = True
) -> Iterator[tuple[Environment, Frame]]:
    """The frames of a drive, each with the environment as it is at its end."""
    env = plan.task.environment(plan.scenario)
    try:
        for frame in drive(
            env,
            driver,
            plan.rule,
            seed=one_number(plan.seed),
            rng=np.random.default_rng((*plan.seed, _RULE)),
            can_look_up=plan.task.can_look_up,
            measure=measure,
        ):
            yield env, frame
    finally:
        env.close()


def one_number(seed: tuple[int, ...]) -> int:
    """A seed of several numbers below 2**32 as one, for Gymnasium: NumPy draws the same of both."""
    return sum(number << (32 * place) for place, number in enumerate(seed))
