"""What a car has around it, and where traffic starts."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.cars import LENGTH, WIDTH, Cars, place
from pipeline.driving.features import SENSOR_RANGE
from pipeline.driving.tracks import LANE_WIDTH, Track

SPEED_LIMIT = 20.0  # [m/s], 45 mph: our car's
TRAFFIC_SPEEDS = (10.0, 16.0)  # [m/s] low and high limit of the traffic cars
SLOT = 16.0  # [m] of lane that a car needs at the start
LANE_MARGIN = 0.4  # [m] that a car may reach over a line before it counts as in the next lane too


type Begins = Literal["anywhere", "line"]
"""Where our car begins a drive."""


def along_road(cars: Cars, track: Track, first: int | None = None) -> NDArray[np.float64]:
    """[N, N] (m) along the road from car i's centre to car j's, within half a lap; a car is
    infinitely far from itself. Of the `first` cars only, all by default.
    """
    along = cars.s - cars.s[:first, None]
    along = np.remainder(along + track.length / 2, track.length) - track.length / 2
    along.ravel()[:: len(cars) + 1] = np.inf
    return along


def gap_ahead(along: NDArray[np.float64], relevant: NDArray[np.bool_]) -> NDArray[np.float64]:
    """[..., N] (m) bumper to bumper to the nearest `relevant` [..., N, M] car in front, from 0 to
    SENSOR_RANGE; `along` is [N, M].
    """
    gaps = np.where(relevant, np.where(along > 0, along - LENGTH, np.inf), np.inf)
    return np.minimum(np.maximum(gaps.min(axis=-1), 0.0), SENSOR_RANGE)


def reaches(d: NDArray[np.float64], centre: NDArray[np.float64]) -> NDArray[np.bool_]:
    """[..., M]: whether car j at lateral position `d` [M] (m) reaches into the lane around `centre`
    [...] (m).
    """
    return np.abs(d - centre[..., None]) < 0.5 * (LANE_WIDTH + WIDTH) - LANE_MARGIN


def check_room(track: Track, traffic: int) -> None:
    """Raise ValueError unless `traffic` cars besides ours find room at the start."""
    room = int(track.length / SLOT) * track.lanes
    if not 0 <= traffic < room:
        raise ValueError(
            f"traffic is {traffic}, expected 0 to {room - 1} cars on track {track.name}"
        )


def start(
    track: Track,
    traffic: int,
    spread: tuple[float, float],
    rng: np.random.Generator,
    *,
    begins: Begins = "anywhere",
) -> Cars:
    """Our car and `traffic` others at random, in lanes, none inside another.

    `spread` is the standard deviation of our own lateral offset [m] and angle [rad] (the paper's
    S_0); the others start centred. On the "line", where s is 0, only our lane is left to chance.

    Raises:
        ValueError: the track has no room for so many cars.
    """
    check_room(track, traffic)
    along = int(track.length / SLOT)
    slots = rng.permutation(along * track.lanes)[: traffic + 1]
    on_line = begins == "line"
    if on_line:
        ours = slots[0] % track.lanes  # the first slot of its lane, for which who has it gets ours
        slots[slots == ours], slots[0] = slots[0], ours
    play = track.length / along - LENGTH - 2.0
    s = (slots // track.lanes) * track.length / along + rng.uniform(0, play, traffic + 1)
    s[0] = 0.0 if on_line else s[0]
    d = track.lane_centres[slots % track.lanes].copy()
    angle = np.zeros(traffic + 1)
    offset, angle[0] = rng.normal(0, spread[0]), np.clip(rng.normal(0, spread[1]), -0.3, 0.3)
    reach = 0.5 * (LENGTH * np.abs(np.sin(angle[0])) + WIDTH * np.cos(angle[0]))
    beside = LANE_WIDTH - 0.5 * WIDTH - 0.1 - reach  # [m] to a car in the next lane, but for 10 cm
    d[0] += np.clip(offset, -beside, beside)
    limit = rng.uniform(*TRAFFIC_SPEEDS, traffic + 1)
    limit[0] = SPEED_LIMIT
    return place(track, s, d, angle, limit)
