"""What can be drawn while it is driven: a car on its track; and what a drive has come to."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.environment import DrivingEnv
from pipeline.driving.task import Driving
from pipeline.driving.world import World
from pipeline.inspection.footage import Footage
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement, rule_of
from pipeline.rollout.loop import Frame
from pipeline.rollout.plans import Plan, driven, stream
from pipeline.rollout.strategies import Strategy
from pipeline.task import Task


@dataclass(frozen=True)
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
    done: float = 0.0
    """share of the drive [0, 1]: of its time or of its laps, whichever is more"""
    ended: str | None = None
    """why it is over, None if it is not"""
    _drives: bool = False
    """whether the reference does"""

    def after(self, frame: Frame, task: Driving) -> Tally:
        """With one more frame, of a drive of this task."""
        has_primary = not np.isnan(frame.primary_action).any()
        laps, frames = frame.outcome["laps"], self.frames + 1
        return Tally(
            laps=laps,
            damage=frame.outcome["damage"],
            frames=frames,
            by_reference=self.by_reference + frame.intervention,
            takeovers=self.takeovers + (frame.intervention and has_primary and not self._drives),
            done=min(max(laps / task.laps, frames / (task.seconds * task.fps)), 1.0),
            ended=frame.ended,
            _drives=frame.intervention,
        )

    def __str__(self) -> str:
        so_far = (
            f"{self.laps:.2f} laps, damage {self.damage:.2f}, {self.frames} frames, "
            f"{self.by_reference} of them by the reference, {self.takeovers} takeovers"
        )
        return so_far if self.ended is None else f"{so_far}; ended: {self.ended}"


def plan_to_draw(task: Task, strategy: Strategy, judgement: Judgement | None, seed: int) -> Plan:
    """A drive on the track of a task; ValueError where there are several, the task is not the car's, or
    as `rule_of`.
    """
    car = _car(task)
    if len(car.scenarios) > 1:
        raise ValueError(f"tracks is {car.tracks!r}, expected a single one to draw")
    rule = rule_of(strategy, judgement)
    return Plan(car, car.scenarios[0], rule, (seed, stream("film")))


def drawn(plan: Plan, driver: Driver | None) -> Iterator[tuple[World, Frame, Tally]]:
    """The frames of a drive, each with the world and the tally as they are at its end; ValueError where
    the task is not the car's.
    """
    car, tally = _car(plan.task), Tally()
    for env, frame in driven(plan, driver):
        assert isinstance(env, DrivingEnv)  # what Driving makes
        tally = tally.after(frame, car)
        yield env.world, frame, tally


def watched(
    plan: Plan, driver: Driver | None, judgement: Judgement | None = None
) -> Iterator[tuple[Footage, Tally]]:
    """The frames of a drive one by one, each with what the drive has come to at its end. Raises as `drawn`.

    All other cars are known, but in the first frame: where they were when it began, nobody saw.
    """
    others: NDArray[np.float64] = np.empty((0, 3))
    for number, (world, frame, tally) in enumerate(drawn(plan, driver)):
        end = world.vehicle_state()[:2]
        yield Footage.of_frame(number, frame, end, others, judgement), tally
        cars = world.cars
        others = np.stack([cars.x, cars.y, cars.heading], axis=1)[1:]


def in_real_time[Item](items: Iterator[Item], per_second: float) -> Iterator[Item]:
    """The items no sooner than `per_second` of them are due; later where they are not ready."""
    start = time.monotonic()
    for number, item in enumerate(items):
        time.sleep(max(start + number / per_second - time.monotonic(), 0.0))
        yield item


def _car(task: Task) -> Driving:
    if not isinstance(task, Driving):
        raise ValueError(f"task is {task.name!r}, expected one that can be drawn: {Driving.name}")
    return task
