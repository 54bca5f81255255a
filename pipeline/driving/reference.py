"""The reference policy: a rule-based driver that sees the true state.

It follows its lane up to the speed limit, changes lane for a car ahead where there is room, else
brakes (Sec. 4.1). It is a pure function of the state, so that a label can be replayed, and its rules
rest on what one camera frame can show: gaps ahead, never speeds. Only the look over the shoulder
does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.cars import LENGTH, LOCK, WHEELBASE, WIDTH, Cars
from pipeline.driving.features import SENSOR_RANGE
from pipeline.driving.tracks import Track
from pipeline.driving.traffic import along_road, gap_ahead, reaches

LOOK_AHEAD = 10.0  # [m] to the point that the wheels are aimed at
PULL = 0.5  # [m] the farthest that this point may lie beside the car's own line: keeps returns and lane changes gentle
CHANGE_GAP = 46.0  # [m] a car ahead nearer than this starts to pull towards a free lane ...
CHANGE_FADE = 24.0  # [m] ... and in full when it is this much nearer still: a gap misread by a metre hardly shows
ADVANTAGE = 12.0  # [m] that the next lane must be freer than this one
REAR_GAP, REAR_TIME = 8.0, 1.5  # [m], [s] for a car behind in the next lane: more if it is faster
BRAKE_TIME = 1.0  # [s] brake when the car in our path is nearer than this at our limit (20 m): enough to stop
CLOSE = 7.0  # [m] nearer than this a car that we overlap is in our path, wherever we are heading
PATH_MARGIN = 0.35  # [m] beside the car that still counts as its path
_LEFT_HERE_RIGHT = np.array([[-1], [0], [1]])


def reference_actions(cars: Cars, track: Track) -> NDArray[np.float32]:
    """What the reference would do in each car's place: [N, 2] steering in [-1, 1] and brake in {0, 1}."""
    along = along_road(cars, track)
    angle = cars.angle(track)
    heading_for = cars.d + LOOK_AHEAD * np.sin(angle)
    steering = _aim(cars, track, cars.d + _lateral_pull(cars, track, along, heading_for))
    brake = _gap_in_path(cars, along, heading_for) < BRAKE_TIME * cars.limit
    return np.stack([steering, brake], axis=1).astype(np.float32)


def _lateral_pull(
    cars: Cars, track: Track, along: NDArray[np.float64], heading_for: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] (m) to the left: towards the middle of the lane, or into a freer one while a car ahead is near."""
    lanes = track.lane_of(0.5 * (cars.d + heading_for)) + _LEFT_HERE_RIGHT
    centres = track.lane_centres.take(lanes, mode="clip")
    there = reaches(cars.d, centres)
    free = gap_ahead(along, there)
    here, beside = free[1], free[::2]
    exists = (lanes[::2] >= 0) & (lanes[::2] < track.lanes)
    better = beside > np.minimum(here + ADVANTAGE, SENSOR_RANGE - 1.0)
    taken = (there[::2] | reaches(heading_for, centres[::2])) & _is_beside_or_behind(cars, along)
    left, right = np.where(exists & better & ~taken.any(axis=-1), beside, 0.0)
    keep = np.minimum(np.maximum(centres[1] - cars.d, -PULL), PULL)
    change = np.where(left >= right, PULL, -PULL)
    nearness = np.minimum(np.maximum((CHANGE_GAP - here) / CHANGE_FADE, 0.0), 1.0)
    urgency = nearness * (np.maximum(left, right) > 0)
    return urgency * change + (1.0 - urgency) * keep


def _is_beside_or_behind(cars: Cars, along: NDArray[np.float64]) -> NDArray[np.bool_]:
    """[N, N]: whether car j would be in car i's way if that changed into its lane."""
    closing = np.maximum(cars.speed - cars.speed[:, None], 0.0)
    return (along < LENGTH + 2.0) & (along > -(LENGTH + REAR_GAP + REAR_TIME * closing))


def _gap_in_path(
    cars: Cars, along: NDArray[np.float64], heading_for: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] (m) to the nearest car in the path: where the car is heading, and close by where it is."""
    reach = WIDTH + PATH_MARGIN
    beside = np.abs(cars.d - cars.d[:, None]) < reach
    ahead = np.abs(cars.d - heading_for[:, None]) < reach
    return gap_ahead(along, ahead | (beside & (along < LENGTH + CLOSE)))


def _aim(cars: Cars, track: Track, d: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pure pursuit of the point LOOK_AHEAD along the road at lateral position `d` [N] (m): steering in [-1, 1]."""
    x, y = track.centreline.position(cars.s + LOOK_AHEAD, d)
    dx, dy = x - cars.x, y - cars.y
    beside = -dx * np.sin(cars.heading) + dy * np.cos(cars.heading)
    wheel = np.arctan(2.0 * WHEELBASE * beside / (dx**2 + dy**2))
    return np.minimum(np.maximum(wheel / LOCK, -1.0), 1.0)
