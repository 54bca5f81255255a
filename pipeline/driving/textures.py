"""Pictures for the renderer, painted from a track's look. All are RGB uint8.

TinyRenderer samples a texture without filtering, so a lane line that is thinner than a pixel comes
out as confetti. The road is therefore painted at several levels, each blurred to the width of a
pixel at the distance where it is used (mip-mapping by hand).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from pipeline.driving.tracks import Look, Track

TEXEL = 0.1  # [m] of road across a texel at full detail
LINE_WIDTH, EDGE_WIDTH = 0.24, 0.30  # [m]

Image = NDArray[np.uint8]


def road(track: Track, rng: np.random.Generator, period: float) -> Image:
    """One dash period [m] of road at full detail: rows run along the road, columns from its left
    edge to its right.
    """
    width, rows = 2 * track.half_width, round(period / (4 * TEXEL))
    across = (np.arange(round(width / TEXEL)) + 0.5) * TEXEL - track.half_width
    along = (np.arange(rows) + 0.5) * period / rows
    look = track.look
    grain = gaussian_filter(rng.normal(0, 3 * look.grain, (rows, len(across))), 1.0, mode="wrap")
    grey = look.asphalt + grain
    image = np.repeat(grey[..., None], 3, axis=2)
    dashes = along < look.dash[0]
    for d in track.lane_lines:
        image[np.ix_(dashes, np.abs(across - d) < LINE_WIDTH / 2)] = look.line
    for d in track.edge_lines:
        image[:, np.abs(across - d) < EDGE_WIDTH / 2] = look.edge
    return np.clip(image, 0, 255).astype(np.uint8)


def blurred(image: Image, across: float, along: float) -> Image:
    """A road texture seen from afar: averaged over about `across` and `along` [m], its size
    unchanged.
    """
    sigma = (along / (4 * TEXEL), across / TEXEL, 0)
    return gaussian_filter(image.astype(float), sigma, mode=("wrap", "nearest", "nearest")).astype(
        np.uint8
    )


def ground(look: Look, rng: np.random.Generator, texels: int = 64) -> Image:
    """A tile of the surroundings: patches of lighter and darker ground, seamless."""
    noise = sum(
        share * gaussian_filter(rng.normal(0, scale, (texels, texels)), scale, mode="wrap")
        for scale, share in ((1, 0.12), (3, 0.25), (8, 0.35))
    )
    return np.clip(np.array(look.ground) * (1 + np.asarray(noise)[..., None]), 0, 240).astype(
        np.uint8
    )
