"""A drive to look at while it is driven."""

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pipeline.inspection.drawn import Tally, drawn
from pipeline.inspection.footage import Footage
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.plans import Plan


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
