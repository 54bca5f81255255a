"""A drive to look at while it is driven."""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.environment import DrivingEnv
from pipeline.driving.world import World
from pipeline.inspection.footage import Footage
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.plans import Plan, driven


def watched(
    plan: Plan, driver: Driver | None, judgement: Judgement | None = None
) -> Iterator[tuple[World, Footage]]:
    """The frames of a drive one by one, each with the world as it is at its end.

    All other cars are known, but in the first frame: where they were when it began, nobody saw.
    """
    others: NDArray[np.float64] = np.empty((0, 3))
    for number, (env, frame) in enumerate(driven(plan, driver)):
        assert isinstance(env, DrivingEnv)
        world = env.world
        end = world.vehicle_state()[:2]
        yield world, Footage.of_frame(number, frame, end, others, judgement)
        cars = world.cars
        others = np.stack([cars.x, cars.y, cars.heading], axis=1)[1:]


def in_real_time[Item](items: Iterator[Item], per_second: float) -> Iterator[Item]:
    """The items no sooner than `per_second` of them are due; later where they are not ready."""
    start = time.monotonic()
    for number, item in enumerate(items):
        time.sleep(max(start + number / per_second - time.monotonic(), 0.0))
        yield item


@dataclass
class Tally:
    """What a drive has come to so far."""

    laps: float = 0.0
    damage: float = 0.0
    """[m^2/s^2]"""
    frames: int = 0
    by_reference: int = 0
    """of the frames"""
    takeovers: int = 0
    """how often the reference took over from a primary"""
    _drives: bool = False
    """whether the reference does"""

    def add(self, world: World, footage: Footage) -> None:
        """Count one more frame, and the world as it is at its end."""
        has_primary = not np.isnan(footage.primary_action).any()
        drives = bool(footage.intervention[0])
        self.laps, self.damage = world.laps, world.damage
        self.frames += 1
        self.by_reference += drives
        self.takeovers += drives and has_primary and not self._drives
        self._drives = drives

    def __str__(self) -> str:
        return (
            f"{self.laps:.2f} laps, damage {self.damage:.2f}, {self.frames} frames, "
            f"{self.by_reference} of them by the reference, {self.takeovers} takeovers"
        )
