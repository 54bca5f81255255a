"""Hand-made scenes: tracks to choose from, and cars put where a test wants them."""

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies

from pipeline.driving.cars import LENGTH, WIDTH, Cars, place
from pipeline.driving.tracks import TEST, TRAINING, Track

NAMES = [*TRAINING, *TEST]

track_names = strategies.sampled_from(NAMES) | strategies.integers(0, 10_000).map(
    "random:{}".format
)


def cars_at(
    track: Track,
    s: Sequence[float],
    lane: Sequence[int],
    *,
    offset: float | Sequence[float] = 0.0,
    angle: float | Sequence[float] = 0.0,
    limit: float | Sequence[float] = 15.0,
) -> Cars:
    """Cars at `s` [m] in these lanes, ours first, beside the middle by `offset` [m] to the left.

    Each drives at its `limit` [m/s], turned by `angle` [rad] against its lane.
    """
    d = track.lane_centres[list(lane)] + offset
    whole = np.zeros(len(s))
    return place(track, np.array(s, float), d, whole + angle, whole + limit)


def straightest(track: Track) -> float:
    """The arc length [m] in the middle of the straightest 40 m of the track."""
    curvature = np.abs(track.centreline.curvature)
    window = int(40.0 / track.length * len(curvature))
    around = np.concatenate([curvature[-window:], curvature, curvature[:window]])
    mean = np.convolve(around, np.ones(window) / window, mode="same")[window:-window]
    return float(np.argmin(mean)) * track.length / len(curvature)


def overlapping(cars: Cars, size: tuple[float, float] = (LENGTH, WIDTH)) -> list[tuple[int, int]]:
    """Pairs of cars whose rectangles of this `size` [m] overlap, by the separating axis theorem."""
    apart = np.hypot(cars.x[:, None] - cars.x, cars.y[:, None] - cars.y)
    near = np.argwhere(np.triu(apart < np.hypot(*size), 1))
    return [(int(i), int(j)) for i, j in near if not _separable(cars, i, j, size)]


def _separable(cars: Cars, i: int, j: int, size: tuple[float, float]) -> bool:
    axes = np.concatenate([_axes(cars, i), _axes(cars, j)])
    one, other = (_corners(cars, k, size) @ axes.T for k in (i, j))
    gaps = np.maximum(one.min(0) - other.max(0), other.min(0) - one.max(0))
    return bool(np.any(gaps > 0))


def _axes(cars: Cars, i: int) -> np.ndarray:
    along = [np.cos(cars.heading[i]), np.sin(cars.heading[i])]
    return np.array([along, [-along[1], along[0]]])


def _corners(cars: Cars, i: int, size: tuple[float, float]) -> np.ndarray:
    signs = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    return np.array([cars.x[i], cars.y[i]]) + 0.5 * signs * size @ _axes(cars, i)
