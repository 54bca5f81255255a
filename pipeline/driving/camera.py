"""The front camera: 160 x 72 RGB by TinyRenderer, from just above the car."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.bullet import pybullet
from pipeline.driving.scene import Scene

HEIGHT, WIDTH = 72, 160  # pixels
FIELD_OF_VIEW = 36.0  # [degrees], vertical; 72 horizontally
BACK, UP = 1.0, 1.9  # [m] behind and above the middle of the car, seen from the road
PITCH = 0.07  # [rad] downwards
NEAR, FAR = 0.3, 260.0  # [m]
PROJECTION = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, WIDTH / HEIGHT, NEAR, FAR)
LIGHT = (0.3, 0.4, 1.0)
WHITE = 0xFFFFFFFF  # TinyRenderer leaves this where nothing was drawn, and no texture of ours is as bright


def render(scene: Scene, x: float, y: float, heading: float) -> NDArray[np.uint8]:
    """What a car at (x, y) [m] turned to `heading` [rad] sees: uint8 [72, 160, 3]."""
    ahead = np.array([np.cos(heading), np.sin(heading)])
    eye = np.array([x, y]) - BACK * ahead
    target = eye + ahead
    view = pybullet.computeViewMatrix((*eye, UP), (*target, UP - np.tan(PITCH)), (0.0, 0.0, 1.0))
    _, _, rgba, _, _ = pybullet.getCameraImage(
        WIDTH,
        HEIGHT,
        view,
        PROJECTION,
        lightDirection=LIGHT,
        shadow=0,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=scene.client,
    )
    pixels = (
        np.frombuffer(bytearray(rgba), np.uint8)
        if isinstance(rgba, tuple)
        else np.asarray(rgba, np.uint8)
    )
    image = pixels.reshape(HEIGHT, WIDTH, 4)
    empty = image.view(np.uint32) == WHITE
    return np.where(empty, _sky(scene.track.look.sky), image[..., :3])


@lru_cache(maxsize=16)
def _sky(colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """[72, 1, 3], paler towards the horizon."""
    pale = np.linspace(0.0, 0.5, HEIGHT // 2).repeat(2)[:, None, None]
    return (np.array(colour) * (1 - pale) + 235 * pale).astype(np.uint8)
