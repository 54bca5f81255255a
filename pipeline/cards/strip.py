"""A strip of sample frames, small enough to lie in git beside a card."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.driving.features import IMAGE_SHAPE

COUNT = 6  # frames in a strip
GAP = 2  # [pixels] of white between frames
QUALITY = 80  # of the JPEG: about 4 kB a frame


def sample_rows(frames: int, count: int = COUNT) -> list[int]:
    """The rows in the middle of `count` equal parts of `frames` rows; all where there are fewer."""
    count = min(count, frames)
    return [(2 * part + 1) * frames // (2 * count) for part in range(count)]


def strip(images: Sequence[NDArray[np.uint8]]) -> bytes:
    """Images [72, 160, 3] beside each other, as a JPEG; the same images give the same bytes."""
    gap = np.full((IMAGE_SHAPE[0], GAP, 3), 255, np.uint8)
    parts = [part for image in images for part in (gap, image)][1:]
    picture = cv2.cvtColor(np.concatenate(parts, axis=1), cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
