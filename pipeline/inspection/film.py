"""A drive as a film: what the car sees and who drives, and beneath it the track from above.

In the shapes, H and W are the height and width of a picture.
"""

import io
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.driving.cars import LENGTH, WIDTH, Cars
from pipeline.driving.features import CAMERA
from pipeline.driving.world import World
from pipeline.inspection.drawn import Tally, drawn
from pipeline.inspection.tracks import ToPixels, track_map
from pipeline.policies.inference import Driver
from pipeline.rollout.loop import Frame
from pipeline.rollout.plans import Plan

WIDE = 480  # [px] the film
ENLARGED = 1.5  # the camera's picture, which leaves room beside it for words
LINE = 24  # [px] of text
COLOURS = 64  # in the palette of the whole film
PRIMARY, REFERENCE = (0, 90, 200), (213, 60, 0)
TRAFFIC, OUTLINE, INK, PAPER = (240, 228, 66), (0, 0, 0), (20, 20, 20), (255, 255, 255)
SUBPIXELS = 3  # bits: cv2 draws at eighths of a pixel


def shoot(plan: Plan, driver: Driver, name: str) -> Iterator[tuple[NDArray[np.uint8], Tally]]:
    """Drive, and show each frame, uint8 [H, 480, 3], with the primary's name and what the drive has come
    to so far. The trail is blue where the primary drove, red where the reference did. Raises as `drawn`.
    """
    ground, to_pixels = track_map(plan.scenario, WIDE)
    trail: NDArray[np.float64] | None = None
    for world, frame, tally in drawn(plan, driver):
        here = to_pixels(world.cars.x[:1], world.cars.y[:1])
        if trail is not None:
            line = [_fixed(np.concatenate([trail, here]))]
            cv2.polylines(ground, line, False, _colour(frame), 2, cv2.LINE_AA, SUBPIXELS)
        trail = here
        above = ground.copy()
        _draw_cars(above, world.cars, to_pixels, _colour(frame))
        head = _head(f"{name}, {plan.rule.name}", world, frame, tally.by_reference / tally.frames)
        yield np.concatenate([head, above]), tally


def beside(*films: Sequence[NDArray[np.uint8]]) -> list[NDArray[np.uint8]]:
    """Films of the same height as one, uint8 [H, W + W' ..., 3]; what is over shows its last picture."""
    longest = max(map(len, films))
    parts = ([*film, *[film[-1]] * (longest - len(film))] for film in films)
    return [np.concatenate(pictures, axis=1) for pictures in zip(*parts, strict=True)]


def gif(pictures: Sequence[NDArray[np.uint8]], milliseconds: int) -> bytes:
    """The pictures, uint8 [H, W, 3] of one size, one after the other and again, each for so many
    `milliseconds`, a multiple of 10. Equal ones give equal bytes; none a ValueError.
    """
    if not pictures:
        raise ValueError("there are no pictures, expected at least one")
    # one palette, from pictures of the whole film: a palette each would flicker
    some = np.concatenate(pictures[:: max(1, len(pictures) // 8)])
    palette = Image.fromarray(some).quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in pictures
    ]
    content = io.BytesIO()
    frames[0].save(
        content,
        format="gif",
        save_all=True,
        append_images=frames[1:],
        duration=milliseconds,
        loop=0,
        optimize=False,
    )
    return content.getvalue()


def _colour(frame: Frame) -> tuple[int, int, int]:
    return REFERENCE if frame.intervention else PRIMARY


def _head(title: str, world: World, frame: Frame, share: float) -> NDArray[np.uint8]:
    """The camera's picture, and beside it a title, who drives, and how it has gone so far."""
    seen = cv2.resize(
        frame.observation[CAMERA], None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_LINEAR
    )
    words = np.full((len(seen), WIDE - seen.shape[1], 3), PAPER, np.uint8)
    lines = {
        title: INK,
        f"{'reference' if frame.intervention else 'primary'} drives": _colour(frame),
        f"lap {max(world.laps, 0.0):.2f}, damage {world.damage:.1f}": INK,
        f"reference drove {100 * share:.0f} %": INK,
    }
    for number, (text, colour) in enumerate(lines.items(), 1):
        place = (12, number * LINE)
        cv2.putText(words, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv2.LINE_AA)
    return np.concatenate([seen, words], axis=1)


def _draw_cars(picture: NDArray[np.uint8], cars: Cars, to_pixels: ToPixels, ours: tuple) -> None:
    """Boxes of their true size; ours last, on top."""
    along = np.array([1, 1, -1, -1]) * LENGTH / 2
    beside = np.array([1, -1, -1, 1]) * WIDTH / 2
    for car in reversed(range(len(cars))):
        cos, sin = np.cos(cars.heading[car]), np.sin(cars.heading[car])
        corners = to_pixels(
            cars.x[car] + along * cos - beside * sin, cars.y[car] + along * sin + beside * cos
        )
        box = _fixed(corners)
        cv2.fillPoly(picture, [box], TRAFFIC if car else ours, cv2.LINE_AA, SUBPIXELS)
        cv2.polylines(picture, [box], True, OUTLINE, 1, cv2.LINE_AA, SUBPIXELS)


def _fixed(points: NDArray[np.float64]) -> NDArray[np.int32]:
    return np.round(points * 2**SUBPIXELS).astype(np.int32)
