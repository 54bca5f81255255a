"""Hand-made scenes: tracks to choose from, and cars put where a test wants them."""

from collections.abc import Sequence

import cv2
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
    """Pairs of cars whose rectangles of this `size` [m] overlap."""
    apart = np.hypot(cars.x[:, None] - cars.x, cars.y[:, None] - cars.y)
    near = np.argwhere(np.triu(apart < np.hypot(*size), 1))
    where = zip(cars.x, cars.y, np.degrees(cars.heading), strict=True)
    boxes = [((x, y), size, turned) for x, y, turned in where]
    return [
        (int(i), int(j))
        for i, j in near
        if cv2.rotatedRectangleIntersection(boxes[i], boxes[j])[0] != cv2.INTERSECT_NONE
    ]
