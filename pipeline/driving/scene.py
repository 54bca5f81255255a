"""PyBullet worlds: road, surroundings and cars as bodies, and who touches whom."""

from __future__ import annotations

import tempfile
import weakref
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.driving import meshes, textures
from pipeline.driving.bullet import pybullet
from pipeline.driving.cars import HEIGHT, LENGTH, WIDTH, Cars
from pipeline.driving.props import scatter
from pipeline.driving.tracks import Track

LEVELS = (
    14.0,
    22.0,
    34.0,
    52.0,
    80.0,
)  # [m] ahead of the camera where the next, more blurred, road texture begins
FOCAL, CAMERA_UP = 111.0, 1.9  # [pixels], [m]: what a pixel covers on the road follows from them
PAINTS = (
    (176, 32, 36),
    (28, 74, 160),
    (222, 222, 216),
    (40, 44, 48),
    (226, 150, 30),
    (30, 110, 70),
    (120, 126, 136),
)
KEPT = 8  # scenes of 38 MB that wait for a drive: one of each training track, and one more


class Scene:
    """A DIRECT PyBullet client holding one track and its cars. It is freed with the scene."""

    def __init__(self, track: Track, cars: int) -> None:
        self.track = track
        self.client = pybullet.connect(pybullet.DIRECT)
        self.close = weakref.finalize(self, pybullet.disconnect, self.client)
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=self.client)
        rng = np.random.default_rng([track.seed, 2])
        with tempfile.TemporaryDirectory() as folder:
            self._files = (Path(folder) / str(number) for number in count())
            self._road_textures = self._load_road_textures(rng)
            self._pieces = [
                self._add_mesh(*piece, texture=self._road_textures[0])
                for piece in meshes.road(track)
            ]
            self._add_mesh(
                *meshes.ground(track), texture=self._load(textures.ground(track.look, rng))
            )
            for mesh, colour in scatter(track, rng):
                self._add_mesh(*mesh, colour=colour)
        self.cars = [self._add_car(i) for i in range(cars)]
        self._levels: NDArray[np.intp] = np.zeros(len(self._pieces), dtype=np.intp)

    def place(self, cars: Cars) -> None:
        """Move the cars' bodies to where the cars are."""
        half = 0.5 * cars.heading
        turned = np.sin(half).tolist(), np.cos(half).tolist()
        for body, x, y, sin, cos in zip(
            self.cars, cars.x.tolist(), cars.y.tolist(), *turned, strict=True
        ):
            pybullet.resetBasePositionAndOrientation(
                body,
                (x, y, 0.5 * HEIGHT + 0.15),
                (0.0, 0.0, sin, cos),
                physicsClientId=self.client,
            )

    def forget(self) -> None:
        """Part all cars: who touched whom, and where, is remembered for as long as they are near."""
        for i, body in enumerate(self.cars):
            pybullet.resetBasePositionAndOrientation(
                body, (100.0 * i, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), physicsClientId=self.client
            )
        pybullet.performCollisionDetection(physicsClientId=self.client)

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

    def _load(self, image: NDArray[np.uint8]) -> int:
        path = str(next(self._files).with_suffix(".png"))
        cv2.imwrite(path, image[..., ::-1])
        return pybullet.loadTexture(path, physicsClientId=self.client)

    def _add_mesh(
        self,
        vertices: Sequence[Any] | NDArray[np.float64],
        indices: list[int],
        uvs: Sequence[Any] | None = None,
        *,
        texture: int | None = None,
        colour: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0),
    ) -> int:
        """A body to look at, not to touch."""
        # From a file: vertices that PyBullet is handed in memory, it never frees.
        path = next(self._files).with_suffix(".obj")
        path.write_text(meshes.as_obj(vertices, indices, uvs or [(0.0, 0.0)] * len(vertices)))
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            fileName=str(path),
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


_waiting: list[Scene] = []


def borrow(track: Track, cars: int) -> Scene:
    """A scene of this track with so many cars: one that was given back, else a new one, which takes
    as long to build as a second of driving. They look and feel the same.
    """
    for scene in _waiting:
        if scene.track is track and len(scene.cars) == cars:
            _waiting.remove(scene)
            scene.forget()
            return scene
    return Scene(track, cars)


def give_back(scene: Scene) -> None:
    """For the next drive. Of more than `KEPT`, the one that has waited longest is freed."""
    _waiting.append(scene)
    if len(_waiting) > KEPT:
        _waiting.pop(0).close()
