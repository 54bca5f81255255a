"""The closed loop: a strategy drives our car, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.policies.deviation import deviation
from pipeline.policies.inference import Driver
from pipeline.policies.reference import reference_actions
from pipeline.policies.strategies import Rule
from pipeline.world.cars import CONTROL_HZ
from pipeline.world.world import World

STANDSTILL = 10.0  # [s] without moving after which a drive is halted
NO_ACTION = np.full(2, np.nan, np.float32)


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
    actions = reference_actions(world.cars, world.track)
    for _ in range(int(seconds * CONTROL_HZ / record_every)):
        image = world.image()
        primary_action, safe_probability = _consult(driver, image)
        epsilon = deviation(primary_action[None], actions[:1], include_brake=rule.include_brake)
        intervention = rule.reference_drives(safe_probability, float(epsilon[0]), rng.random())
        frame = Frame(
            image,
            world.affordances(),
            world.vehicle_state(),
            actions[0].copy(),
            primary_action,
            safe_probability,
            intervention,
        )
        action = frame.reference_action if intervention else primary_action
        for _ in range(record_every):
            actions[0] = action
            world.step(actions)
            actions = reference_actions(world.cars, world.track)
        yield frame
        standing = standing + record_every / CONTROL_HZ if world.cars.speed[0] < 0.5 else 0.0
        if world.off_road or world.laps >= laps or standing >= STANDSTILL:
            return


def _consult(driver: Driver | None, image: NDArray[np.uint8]) -> tuple[NDArray[np.float32], float]:
    """The primary's action and its safe probability, NaN where there is no such policy."""
    if driver is None:
        return NO_ACTION, np.nan
    action, conv5 = driver.act(image)
    return action, driver.safe_probability(conv5) if driver.safety else np.nan
