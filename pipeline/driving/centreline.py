"""Closed centrelines: curvilinear coordinates (s, d) along a smooth loop.

`s` is the arc length [m] from the start line, `d` the signed distance [m] from the centreline, left
is positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

POINTS = 2000  # stored a lap: one each 0.3 to 0.4 m
CLEARANCE = 40.0  # [m] between any two stretches of road that are not neighbours
LENGTHS = (520.0, 680.0)  # [m] a lap
AGAINST = 0.1  # least share of the lap that bends against the sense of the loop: both hands must be driven


@dataclass(frozen=True)
class Centreline:
    """A closed curve sampled evenly in arc length. P points."""

    x: NDArray[np.float64]
    """[P] (m)"""
    y: NDArray[np.float64]
    """[P] (m)"""
    heading: NDArray[np.float64]
    """[P] (rad), counter-clockwise from x, unwrapped"""
    curvature: NDArray[np.float64]
    """[P] (1/m), positive in a left-hand bend"""
    length: float
    """[m], once round"""

    def position(self, s: NDArray[np.float64], d: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        """World coordinates (x, y) [m] of the points (s, d) [m]; `s` may run past a lap."""
        x, y, heading, _ = self._at(s)
        return x - d * np.sin(heading), y + d * np.cos(heading)

    def heading_at(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Direction of the centreline [rad] at arc length `s` [m]."""
        heading: NDArray[np.float64] = self._at(s)[2]
        return heading

    def local_coordinates(
        self, x: NDArray[np.float64], y: NDArray[np.float64], near: NDArray[np.float64]
    ) -> tuple[NDArray, NDArray]:
        """(s, d) [m] of world points, found from a nearby arc length `near` [m] by Newton's method."""
        s = near
        for _ in range(2):
            cx, cy, heading, bend = self._at(s)
            dx, dy = x - cx, y - cy
            cos, sin = np.cos(heading), np.sin(heading)
            along = dx * cos + dy * sin
            d = -dx * sin + dy * cos
            s = s + along / np.maximum(1.0 - bend * d, 0.2)
        return s, d

    def _at(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """[4, ...]: x, y and heading at `s`, and the curvature of the point before."""
        where = np.mod(s, self.length) / self.length * len(self.x)
        low = where.astype(np.int64)
        start, step = self._stretches.take(low, axis=2, mode="wrap")
        found: NDArray[np.float64] = start + (where - low) * step
        return found

    @cached_property
    def _stretches(self) -> NDArray[np.float64]:
        """[2, 4, P]: what `_at` finds at each point, and how much of it comes up to the next."""
        turn = np.remainder(_to_next(self.heading) + np.pi, 2 * np.pi) - np.pi
        points = [self.x, self.y, self.heading, self.curvature]
        return np.array([points, [_to_next(self.x), _to_next(self.y), turn, 0.0 * turn]])


def _to_next(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.roll(values, -1) - values


def random_centreline(rng: np.random.Generator, tightest: float, clockwise: bool) -> Centreline:
    """Draw a closed loop whose tightest bend has the radius `tightest` [m].

    The curvature is a random Fourier series over the lap, so it is smooth, and its mean closes the
    heading. A loop is drawn again until the lap has a length within `LENGTHS`, bends both ways, and
    no stretch comes near another.
    """
    while True:
        bend = _random_bend(rng)
        length = float(np.max(np.abs(bend)) * tightest)
        against = np.mean(bend < -0.5)
        if LENGTHS[0] <= length <= LENGTHS[1] and against >= AGAINST:
            loop = _integrated(bend / length, length)
            if _is_clear(loop):
                return _reversed(loop) if clockwise else loop


def _random_bend(rng: np.random.Generator) -> NDArray[np.float64]:
    """Curvature times length, [P], of a closed loop: harmonics 2-6 are drawn, harmonic 1 closes the
    curve.
    """
    lap = np.arange(POINTS) * 2 * np.pi / POINTS
    order = np.arange(2, 7)[:, None]
    amplitude = rng.uniform(0.1, 0.9, (5, 1))
    drawn = np.sum(amplitude * np.cos(order * lap + rng.uniform(0, 2 * np.pi, (5, 1))), axis=0)

    def bend(first: NDArray[np.float64]) -> NDArray[np.float64]:
        return 2 * np.pi * (1 + drawn + first[0] * np.cos(lap) + first[1] * np.sin(lap))

    def gap(first: NDArray[np.float64]) -> NDArray[np.float64]:
        heading = np.cumsum(bend(first)) / POINTS
        return np.array([np.mean(np.cos(heading)), np.mean(np.sin(heading))])

    return bend(least_squares(gap, np.zeros(2)).x)


def _integrated(curvature: NDArray[np.float64], length: float) -> Centreline:
    step = length / len(curvature)
    heading = np.cumsum(curvature) * step
    x, y = np.cumsum(np.cos(heading)) * step, np.cumsum(np.sin(heading)) * step
    return Centreline(x, y, heading, curvature, length)


def _is_clear(loop: Centreline) -> bool:
    """True where points far apart along the loop are far apart in the plane too."""
    every = max(len(loop.x) // 200, 1)
    x, y = loop.x[::every], loop.y[::every]
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    index = np.arange(len(x))
    steps = np.abs(index[:, None] - index)
    along = np.minimum(steps, len(x) - steps) * loop.length / len(x)
    return bool(np.all(apart[along > 2.0 * CLEARANCE] > CLEARANCE))


def _reversed(loop: Centreline) -> Centreline:
    return Centreline(
        loop.x[::-1].copy(),
        loop.y[::-1].copy(),
        loop.heading[::-1] + np.pi,
        -loop.curvature[::-1],
        loop.length,
    )
