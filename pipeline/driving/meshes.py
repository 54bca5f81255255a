"""Road and ground as meshes, and any mesh as a file.

A mesh is its vertices [V, 3] (m), the indices of its triangles' corners, and the texture's
coordinates at each vertex [V, 2].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.tracks import Track

PIECE = 3.0  # [m] of road in a mesh: short, so that clipping at the near plane tears nothing
TILE = 24.0  # [m] side of a ground tile
MARGIN = 160.0  # [m] of ground around the track

Mesh = tuple[list[Sequence[float]], list[int], list[Sequence[float]]]


def road(track: Track) -> Iterator[Mesh]:
    """The road in pieces, from the start line on."""
    count = round(track.length / PIECE)
    period = sum(track.look.dash)
    repeats = round(
        track.length / period
    )  # a whole number, so that the dashes close up at the start line
    s = np.arange(count + 1) * track.length / count
    left, right = (_line(track, s, side * track.half_width) for side in (1.0, -1.0))
    v = s / track.length * repeats
    for i in range(count):
        start = v[i] % 1.0
        end = start + v[i + 1] - v[i]
        corners = [left[i], right[i], left[i + 1], right[i + 1]]
        yield corners, [0, 1, 2, 2, 1, 3], [(0.0, start), (1.0, start), (0.0, end), (1.0, end)]


def ground(track: Track) -> Mesh:
    """A flat grid of tiles under and around the track, 5 cm below the road."""
    line = track.centreline
    columns = np.arange(line.x.min() - MARGIN, line.x.max() + MARGIN + TILE, TILE)
    rows = np.arange(line.y.min() - MARGIN, line.y.max() + MARGIN + TILE, TILE)
    vertices: list[Sequence[float]] = []
    indices: list[int] = []
    uvs: list[Sequence[float]] = []
    for x in columns:
        for y in rows:
            first = len(vertices)
            vertices += [(x + i, y + j, -0.05) for j in (0.0, TILE) for i in (0.0, TILE)]
            uvs += [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            indices += [first, first + 1, first + 2, first + 2, first + 1, first + 3]
    return vertices, indices, uvs


def as_obj(
    vertices: Sequence[Any] | NDArray[np.float64], indices: Sequence[int], uvs: Sequence[Any]
) -> str:
    """A mesh in Wavefront's format, lit from above. No bit of a number is lost."""
    corners = [f"{i + 1}/{i + 1}/1" for i in indices]
    return "\n".join(
        [
            *(f"v {x} {y} {z}" for x, y, z in vertices),
            *(f"vt {u} {v}" for u, v in uvs),
            "vn 0 0 1",
            *(f"f {' '.join(corners[k : k + 3])}" for k in range(0, len(corners), 3)),
            "",
        ]
    )


def _line(track: Track, s: NDArray[np.float64], d: float) -> NDArray[np.float64]:
    """[len(s), 3] (m) points of the road at lateral position `d` [m]."""
    return np.stack([*track.centreline.position(s, np.full(len(s), d)), 0 * s], axis=1)
