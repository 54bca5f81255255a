"""The closed loop: a strategy drives our car, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.deviation import deviation
from pipeline.driving.features import CONTROL_HZ
from pipeline.driving.reference import reference_actions
from pipeline.driving.world import World
from pipeline.policies.inference import Driver
from pipeline.rollout.strategies import Rule

STANDSTILL = 10.0  # [s] without moving after which a drive is halted
NO_ACTION = np.full(2, np.nan, np.float32)


class Ended(StrEnum):
    """Why a drive was over."""

    ROAD_LEFT = "road left"
    STOOD_STILL = "stood still"
    LAPS_DONE = "laps done"
    OUT_OF_TIME = "out of time"
    BUDGET = "budget spent"
    """there was nothing left to ask or to drive: it would have gone on"""

    @property
    def failed(self) -> bool:
        """Whether somebody has to put the car back on its way."""
        return self in (Ended.ROAD_LEFT, Ended.STOOD_STILL)


@dataclass(frozen=True)
class Frame:
    """What was seen, proposed and decided at one moment."""

    image: NDArray[np.uint8]
    """[72, 160, 3]"""
    affordances: NDArray[np.float32]
    """[10]"""
    vehicle_state: NDArray[np.float32]
    """[4], see `World.vehicle_state`"""
    reference_action: NDArray[np.float32]
    """[2]; known to the simulator even where nobody asked: whoever uses it must count it"""
    primary_action: NDArray[np.float32]
    """[2], NaN without a primary"""
    safe_probability: float
    """[0, 1], NaN without a safety policy"""
    intervention: bool
    """the reference drives this frame"""
    distance: float
    """[m] driven along the road when it was over"""
    touches: int
    """of other cars, until then"""
    ended: Ended | None
    """why the drive was over with it; None where it went on"""

    @property
    def squared_error(self) -> float:
        """The deviation epsilon of Sec. 3.1: squared difference of the two steerings; NaN without a
        primary.
        """
        return float(self.primary_action[0] - self.reference_action[0]) ** 2


def drive(
    world: World,
    driver: Driver | None,
    rule: Rule,
    *,
    record_every: int,
    laps: float,
    seconds: float,
    rng: np.random.Generator,
) -> Iterator[Frame]:
    """Drive until the road is left, `laps` are done, `seconds` have passed or the car stands still.

    Whoever drives is asked once a frame, and its action is held for the `record_every` control
    steps of the frame. `rng` draws for a mixture, once a frame.
    """
    standing = 0.0
    frames = int(seconds * CONTROL_HZ / record_every)
    actions = reference_actions(world.cars, world.track)
    for number in range(1, frames + 1):
        image, hidden, state = world.image(), world.affordances(), world.vehicle_state()
        primary_action, safe_probability = _consult(driver, image)
        epsilon = deviation(primary_action[None], actions[:1], include_brake=rule.include_brake)
        intervention = rule.reference_drives(safe_probability, float(epsilon[0]), rng.random())
        reference_action = actions[0].copy()
        action = reference_action if intervention else primary_action
        for _ in range(record_every):
            actions[0] = action
            world.step(actions)
            actions = reference_actions(world.cars, world.track)
        standing = standing + record_every / CONTROL_HZ if world.cars.speed[0] < 0.5 else 0.0
        ended = _ended(world, laps, standing, number == frames)
        yield Frame(
            image,
            hidden,
            state,
            reference_action,
            primary_action,
            safe_probability,
            intervention,
            world.distance,
            world.touches,
            ended,
        )
        if ended:
            return


def _ended(world: World, laps: float, standing: float, last: bool) -> Ended | None:
    if world.off_road:
        return Ended.ROAD_LEFT
    if world.laps >= laps:
        return Ended.LAPS_DONE
    if standing >= STANDSTILL:
        return Ended.STOOD_STILL
    return Ended.OUT_OF_TIME if last else None


def _consult(driver: Driver | None, image: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float]:
    """The primary's action and its safe probability, NaN where there is no such policy.

    Raises:
        ValueError: the primary's action is NaN or infinite.
    """
    if driver is None:
        return NO_ACTION, np.nan
    action, conv5 = driver.act(image)
    if not np.isfinite(action).all():
        raise ValueError(f"the primary's action is {action}, expected finite numbers")
    return action, driver.safe_probability(conv5) if driver.safety else np.nan
