"""All cars of a drive as arrays, moved by a kinematic bicycle model. N cars; car 0 is ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.features import CONTROL_HZ
from pipeline.driving.tracks import Track

DT = 1.0 / CONTROL_HZ  # [s]
LENGTH, WIDTH, HEIGHT = 4.4, 1.8, 1.4  # [m] of every car
WHEELBASE = 2.7  # [m]
LOCK = 0.25  # [rad] of the front wheels at steering 1.0: with it tau = 0.0025 is a wheel angle of 0.0125 rad
STEERING_LAG = 0.10  # [s] time constant between the steering command and the wheels
THROTTLE_GAIN, THROTTLE_MAX = 1.0, 5.0  # [1/s], [m/s^2]: the governor closes in on the speed limit
BRAKE_GAIN, BRAKE_FLOOR = 0.35, 8.0  # [1/s], [m/s^2]: grows with speed, so that queues settle


@dataclass
class Cars:
    """The state of N cars."""

    x: NDArray[np.float64]
    """[N] (m) of the centre"""
    y: NDArray[np.float64]
    """[N] (m)"""
    heading: NDArray[np.float64]
    """[N] (rad), counter-clockwise from x"""
    speed: NDArray[np.float64]
    """[N] (m/s), never negative"""
    wheel: NDArray[np.float64]
    """[N] (rad) angle of the front wheels, left is positive"""
    limit: NDArray[np.float64]
    """[N] (m/s) the speed that each car's governor holds"""
    s: NDArray[np.float64]
    """[N] (m) arc length since the start line, growing from lap to lap"""
    d: NDArray[np.float64]
    """[N] (m) lateral position, left of the centreline is positive"""

    def __len__(self) -> int:
        return len(self.x)

    def angle(self, track: Track, first: int | None = None) -> NDArray[np.float64]:
        """[N] (rad) between each car's heading and its lane's, in [-pi, pi); left is positive. Of
        the `first` cars only, all by default.
        """
        turned = self.heading[:first] - track.centreline.heading_at(self.s[:first])
        return np.remainder(turned + np.pi, 2 * np.pi) - np.pi


def place(
    track: Track,
    s: NDArray[np.float64],
    d: NDArray[np.float64],
    angle: NDArray[np.float64],
    limit: NDArray[np.float64],
) -> Cars:
    """Cars at (s, d) [m], turned by `angle` [rad] against the lane, moving at their limit [m/s]."""
    x, y = track.centreline.position(s, d)
    heading = track.centreline.heading_at(s) + angle
    return Cars(x, y, heading, limit.copy(), np.zeros(len(s)), limit.copy(), s.copy(), d.copy())


def move(cars: Cars, actions: NDArray[np.floating], track: Track) -> None:
    """Advance every car by one control step of DT, in place.

    `actions` is [N, 2]: steering in [-1, 1] (1 is LOCK to the left) and brake (on above 0.5). The
    bicycle model refers to the car's centre, the wheels follow their command with a lag, and a
    governor does the throttle.
    """
    command = np.minimum(np.maximum(actions[:, 0], -1.0), 1.0) * LOCK
    cars.wheel += (command - cars.wheel) * (1.0 - np.exp(-DT / STEERING_LAG))

    throttle = THROTTLE_GAIN * (cars.limit - cars.speed)
    throttle = np.minimum(np.maximum(throttle, -THROTTLE_MAX), THROTTLE_MAX)
    braking = -(BRAKE_FLOOR + BRAKE_GAIN * cars.speed)
    cars.speed = np.maximum(cars.speed + np.where(actions[:, 1] > 0.5, braking, throttle) * DT, 0.0)

    slip = np.arctan(0.5 * np.tan(cars.wheel))
    cars.heading += cars.speed / (0.5 * WHEELBASE) * np.sin(slip) * DT
    course = cars.heading + slip
    cars.x += cars.speed * np.cos(course) * DT
    cars.y += cars.speed * np.sin(course) * DT
    cars.s, cars.d = track.centreline.local_coordinates(cars.x, cars.y, cars.s)
