"""The PyBullet world of one drive: road, surroundings and cars as bodies, and who touches whom."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.driving import textures
from pipeline.driving.bullet import pybullet
from pipeline.driving.cars import HEIGHT, LENGTH, WIDTH, Cars
from pipeline.driving.props import scatter
from pipeline.driving.tracks import Track

PIECE = 3.0  # [m] of road in a body: short, so that clipping at the near plane tears nothing
LEVELS = (
    14.0,
    22.0,
    34.0,
    52.0,
    80.0,
)  # [m] ahead of the camera where the next, more blurred, road texture begins
FOCAL, CAMERA_UP = 111.0, 1.9  # [pixels], [m]: what a pixel covers on the road follows from them
TILE = 24.0  # [m] side of a ground tile
MARGIN = 160.0  # [m] of ground around the track
PAINTS = (
    (176, 32, 36),
    (28, 74, 160),
    (222, 222, 216),
    (40, 44, 48),
    (226, 150, 30),
    (30, 110, 70),
    (120, 126, 136),
)


class Scene:
    """A DIRECT PyBullet client holding one track and its cars. Use as a context manager, or call `close`."""

    def __init__(self, track: Track, cars: int) -> None:
        self.track = track
        self.client = pybullet.connect(pybullet.DIRECT)
        rng = np.random.default_rng([track.seed, 2])
        with tempfile.TemporaryDirectory() as folder:
            self._folder = Path(folder)
            self._road_textures = self._load_road_textures(rng)
            self._pieces = self._lay_road()
            self._add_mesh(
                *_ground_mesh(track), texture=self._load(textures.ground(track.look, rng))
            )
            for mesh, colour in scatter(track, rng):
                self._add_mesh(*mesh, colour=colour)
            self.cars = [self._add_car(i) for i in range(cars)]
        self._levels: NDArray[np.intp] = np.zeros(len(self._pieces), dtype=np.intp)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        pybullet.disconnect(physicsClientId=self.client)

    def place(self, cars: Cars) -> None:
        """Move the cars' bodies to where the cars are."""
        half = 0.5 * cars.heading
        for i, body in enumerate(self.cars):
            pybullet.resetBasePositionAndOrientation(
                body,
                (cars.x[i], cars.y[i], 0.5 * HEIGHT + 0.15),
                (0.0, 0.0, np.sin(half[i]), np.cos(half[i])),
                physicsClientId=self.client,
            )

    def contacts(self) -> list[tuple[int, NDArray[np.float64], float]]:
        """Cars that touch ours: (car, unit normal [2] from it to us, overlap [m]), the deepest point of each."""
        pybullet.performCollisionDetection(physicsClientId=self.client)
        deepest: dict[int, tuple[int, NDArray[np.float64], float]] = {}
        for point in pybullet.getContactPoints(bodyA=self.cars[0], physicsClientId=self.client):
            overlap = -point[8]
            if overlap >= 0 and overlap > deepest.get(point[2], (0, None, -1.0))[2]:
                deepest[point[2]] = (self.cars.index(point[2]), np.array(point[7][:2]), overlap)
        return [deepest[body] for body in sorted(deepest)]

    def focus(self, s: float) -> None:
        """Give each piece of road the texture for its distance ahead of arc length `s` [m]."""
        middle = (np.arange(len(self._pieces)) + 0.5) * self.track.length / len(self._pieces)
        ahead = (
            np.remainder(middle - s + self.track.length / 2, self.track.length)
            - self.track.length / 2
        )
        levels = np.searchsorted(LEVELS, np.abs(ahead))
        for piece in np.flatnonzero(levels != self._levels):
            pybullet.changeVisualShape(
                self._pieces[piece],
                -1,
                textureUniqueId=self._road_textures[levels[piece]],
                physicsClientId=self.client,
            )
        self._levels = levels

    def _load_road_textures(self, rng: np.random.Generator) -> list[int]:
        """The road at full detail, then blurred to what a pixel covers at the start of each level."""
        full = textures.road(self.track, rng, sum(self.track.look.dash))
        distances = np.array([0.0, *LEVELS])
        across = distances / FOCAL
        along = distances**2 / (FOCAL * CAMERA_UP)
        return [
            self._load(textures.blurred(full, a, b))
            for a, b in zip(across, 0.5 * along, strict=True)
        ]

    def _lay_road(self) -> list[int]:
        track = self.track
        count = round(track.length / PIECE)
        period = sum(track.look.dash)
        repeats = round(
            track.length / period
        )  # a whole number, so that the dashes close up at the start line
        s = np.arange(count + 1) * track.length / count
        left = np.stack(
            [*track.centreline.position(s, np.full(count + 1, track.half_width)), 0 * s], axis=1
        )
        right = np.stack(
            [*track.centreline.position(s, np.full(count + 1, -track.half_width)), 0 * s], axis=1
        )
        v = s / track.length * repeats
        pieces = []
        for i in range(count):
            start = v[i] % 1.0
            end = start + v[i + 1] - v[i]
            corners = [left[i], right[i], left[i + 1], right[i + 1]]
            uv = [[0, start], [1, start], [0, end], [1, end]]
            pieces.append(
                self._add_mesh(corners, [0, 1, 2, 2, 1, 3], uv, texture=self._road_textures[0])
            )
        return pieces

    def _load(self, image: NDArray[np.uint8]) -> int:
        path = self._folder / f"{len(list(self._folder.iterdir()))}.png"
        cv2.imwrite(str(path), image[..., ::-1])
        return pybullet.loadTexture(str(path), physicsClientId=self.client)

    def _add_mesh(
        self,
        vertices: Any,
        indices: list[int],
        uvs: Any = None,
        *,
        texture: int | None = None,
        colour: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0),
    ) -> int:
        """A body to look at, not to touch."""
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=[list(map(float, v)) for v in vertices],
            indices=indices,
            uvs=[[0.0, 0.0]] * len(vertices)
            if uvs is None
            else [list(map(float, uv)) for uv in uvs],
            normals=[[0.0, 0.0, 1.0]] * len(vertices),
            rgbaColor=colour,
            physicsClientId=self.client,
        )
        body = pybullet.createMultiBody(0, -1, shape, physicsClientId=self.client)
        if texture is not None:
            pybullet.changeVisualShape(
                body, -1, textureUniqueId=texture, physicsClientId=self.client
            )
        return body

    def _add_car(self, index: int) -> int:
        """A box to touch; to look at, a body, a cabin and lamps."""
        box = pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=(LENGTH / 2, WIDTH / 2, HEIGHT / 2),
            physicsClientId=self.client,
        )
        if index == 0:
            # Ours carries the camera: a speck below the road, or the box itself would be drawn.
            speck = pybullet.createVisualShape(
                pybullet.GEOM_BOX,
                halfExtents=(1e-3,) * 3,
                visualFramePosition=(0, 0, -2.0),
                physicsClientId=self.client,
            )
            return pybullet.createMultiBody(1, box, speck, physicsClientId=self.client)
        paint = tuple(c / 255 for c in PAINTS[index % len(PAINTS)])
        visual = pybullet.createVisualShapeArray(
            shapeTypes=[pybullet.GEOM_BOX] * 5,
            halfExtents=[
                (LENGTH / 2, WIDTH / 2, 0.32),
                (LENGTH / 3.4, WIDTH / 2.25, 0.26),
                (0.05, 0.26, 0.10),
                (0.05, 0.26, 0.10),
                (LENGTH / 2.2, WIDTH / 2.02, 0.14),
            ],
            visualFramePositions=[
                (0, 0, -0.14),
                (-0.1, 0, 0.42),
                (-LENGTH / 2, WIDTH / 2 - 0.28, -0.02),
                (-LENGTH / 2, -WIDTH / 2 + 0.28, -0.02),
                (0, 0, -0.60),
            ],
            rgbaColors=[
                (*paint, 1),
                (0.10, 0.12, 0.15, 1),
                (0.8, 0.05, 0.05, 1),
                (0.8, 0.05, 0.05, 1),
                (0.07, 0.07, 0.07, 1),
            ],
            physicsClientId=self.client,
        )
        return pybullet.createMultiBody(1, box, visual, physicsClientId=self.client)


def _ground_mesh(track: Track) -> tuple[list[list[float]], list[int], list[list[float]]]:
    """A flat grid of tiles under and around the track, 5 cm below the road."""
    line = track.centreline
    columns = np.arange(line.x.min() - MARGIN, line.x.max() + MARGIN + TILE, TILE)
    rows = np.arange(line.y.min() - MARGIN, line.y.max() + MARGIN + TILE, TILE)
    vertices: list[list[float]] = []
    indices: list[int] = []
    uvs: list[list[float]] = []
    for x in columns:
        for y in rows:
            first = len(vertices)
            vertices += [
                [x, y, -0.05],
                [x + TILE, y, -0.05],
                [x, y + TILE, -0.05],
                [x + TILE, y + TILE, -0.05],
            ]
            uvs += [[0, 0], [1, 0], [0, 1], [1, 1]]
            indices += [first, first + 1, first + 2, first + 2, first + 1, first + 3]
    return vertices, indices, uvs
