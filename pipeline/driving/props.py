"""What stands beside the road: trees, houses or posts, as coloured meshes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.tracks import Track

SPACING = {"trees": 14.0, "houses": 30.0, "posts": 12.0}  # [m] along the road, on each side
CLEAR = 3.0  # [m] between any prop and any asphalt

Mesh = tuple[NDArray[np.float64], list[int]]
Colour = tuple[float, float, float, float]


def scatter(track: Track, rng: np.random.Generator) -> Iterator[tuple[Mesh, Colour]]:
    """The meshes (vertices [V, 3] in m, triangle indices) and colours of a track's props, one mesh
    a colour.
    """
    places = _places(track, rng)
    if track.look.props == "trees":
        sizes = rng.uniform(0.8, 1.5, len(places))
        yield (
            _merged(
                _cone(x, y, 1.2 * k, 6.0 * k, 1.2) for (x, y), k in zip(places, sizes, strict=True)
            ),
            (0.13, 0.30, 0.14, 1),
        )
        yield _merged(_box(x, y, 0.3, 0.3, 1.4) for x, y in places), (0.32, 0.22, 0.14, 1)
    elif track.look.props == "houses":
        sizes = rng.uniform(3.0, 6.0, (len(places), 2))
        yield (
            _merged(_box(x, y, a, b, 4.5) for (x, y), (a, b) in zip(places, sizes, strict=True)),
            (0.66, 0.56, 0.48, 1),
        )
        yield (
            _merged(
                _cone(x, y, max(k) * 1.1, 2.6, 4.5) for (x, y), k in zip(places, sizes, strict=True)
            ),
            (0.45, 0.20, 0.16, 1),
        )
    else:
        yield _merged(_box(x, y, 0.25, 0.25, 1.1) for x, y in places), (0.85, 0.85, 0.85, 1)


def _places(track: Track, rng: np.random.Generator) -> NDArray[np.float64]:
    """[K, 2] (m) points beside the road and clear of all of it."""
    line, spacing = track.centreline, SPACING[track.look.props]
    near = 2.0 if track.look.props == "posts" else 7.0
    deep = 0.3 if track.look.props == "posts" else 16.0
    s = np.arange(0, track.length - spacing / 2, spacing)
    s = np.concatenate([s, s]) + rng.uniform(0, spacing / 3, 2 * len(s))
    side = np.repeat([1.0, -1.0], len(s) // 2)
    x, y = line.position(s, side * (track.half_width + near + rng.uniform(0, deep, len(s))))
    apart = np.hypot(x[:, None] - line.x[None, ::8], y[:, None] - line.y[None, ::8]).min(axis=1)
    clear = apart > track.half_width + min(near, CLEAR) - 0.5
    return np.stack([x, y], axis=1)[clear]


def _box(x: float, y: float, half_x: float, half_y: float, height: float) -> Mesh:
    corners = np.array([[i, j, k] for k in (0, 1) for j in (-1, 1) for i in (-1, 1)], dtype=float)
    vertices = corners * [half_x, half_y, height] + [x, y, 0]
    sides = [(0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6), (4, 5, 7, 6)]
    return vertices, [i for a, b, c, d in sides for i in (a, b, c, a, c, d)]


def _cone(x: float, y: float, radius: float, height: float, base: float, sides: int = 6) -> Mesh:
    turn = np.arange(sides) * 2 * np.pi / sides
    rim = np.stack(
        [x + radius * np.cos(turn), y + radius * np.sin(turn), np.full(sides, base)], axis=1
    )
    vertices = np.concatenate([rim, [[x, y, base + height]]])
    return vertices, [i for k in range(sides) for i in (k, (k + 1) % sides, sides)]


def _merged(meshes: Iterator[Mesh]) -> Mesh:
    vertices: list[NDArray[np.float64]] = []
    indices: list[int] = []
    for points, triangles in meshes:
        first = sum(len(v) for v in vertices)
        vertices.append(points)
        indices += [first + i for i in triangles]
    return np.concatenate(vertices), indices
