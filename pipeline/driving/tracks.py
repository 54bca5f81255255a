"""The ten tracks of the experiment, and the family that they and every `random:<seed>` track are
drawn from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.centreline import Centreline, random_centreline

LANE_WIDTH = 3.6  # [m]
SHOULDER = 0.6  # [m] of asphalt outside the outermost lanes
TIGHTEST = (37.0, 44.0)  # [m] radius of a track's tightest bend, low and high
RANDOM_PREFIX = "random:"


@dataclass(frozen=True)
class Look:
    """What a track looks like; colours are RGB, 0-255."""

    asphalt: int
    """grey level of the road surface"""
    grain: int
    """amplitude of the road's noise, in grey levels"""
    line: tuple[int, int, int]
    """lane markings"""
    edge: tuple[int, int, int]
    """edge lines"""
    dash: tuple[float, float]
    """[m] painted and unpainted stretch between two lanes"""
    ground: tuple[int, int, int]
    """surroundings"""
    props: str
    """what stands beside the road: one of PROPS"""
    sky: tuple[int, int, int]
    """colour of the sky"""


WHITE, YELLOW = (235, 235, 230), (230, 190, 60)
GRASS, MEADOW, SAND, SNOW = (84, 122, 60), (132, 140, 74), (186, 164, 118), (214, 218, 222)
CLEAR, HAZE, DUSK = (134, 176, 222), (190, 200, 208), (206, 176, 160)
DASHES = ((3.0, 6.0), (4.0, 8.0), (6.0, 6.0))
PROPS = ("trees", "houses", "posts")


@dataclass(frozen=True)
class Track:
    """A closed multi-lane road. Lanes are numbered from the left, 0 first."""

    name: str
    centreline: Centreline
    lanes: int
    """2 to 4"""
    look: Look
    seed: int
    """draws what is scattered along the road"""

    @property
    def length(self) -> float:
        """[m], one lap along the centreline."""
        return self.centreline.length

    @property
    def half_width(self) -> float:
        """[m] from the centreline to the end of the asphalt: a car whose centre is beyond has left
        the road.
        """
        return self.lanes * LANE_WIDTH / 2 + SHOULDER

    @cached_property
    def lane_centres(self) -> NDArray[np.float64]:
        """[lanes] (m) lateral position of each lane's middle, left (positive) first."""
        return ((self.lanes - 1) / 2 - np.arange(self.lanes, dtype=np.float64)) * LANE_WIDTH

    @cached_property
    def lane_lines(self) -> NDArray[np.float64]:
        """[lanes - 1] (m) lateral position of each line between two lanes, right (negative) first."""
        return np.arange(1, self.lanes, dtype=np.float64) * LANE_WIDTH - self.lanes * LANE_WIDTH / 2

    @property
    def edge_lines(self) -> tuple[float, float]:
        """(m) lateral positions of the lines outside the outermost lanes, right (negative) first."""
        edge = self.half_width - SHOULDER
        return -edge, edge

    def lane_of(self, d: NDArray[np.float64]) -> NDArray[np.int64]:
        """The lane nearest to the lateral position `d` [m]."""
        lane = np.rint((self.lanes - 1) / 2 - d / LANE_WIDTH)
        return np.minimum(np.maximum(lane, 0), self.lanes - 1).astype(np.int64)


@dataclass(frozen=True)
class Design:
    """The choices behind a named track."""

    seed: int
    lanes: int
    clockwise: bool
    look: Look


# The test tracks' shapes are new; their looks combine what the training tracks show one by one.
TRAINING = {
    "alder": Design(1, 3, False, Look(92, 14, WHITE, WHITE, DASHES[0], GRASS, "trees", CLEAR)),
    "birch": Design(2, 2, True, Look(118, 18, WHITE, YELLOW, DASHES[1], MEADOW, "houses", HAZE)),
    "cedar": Design(3, 4, False, Look(76, 10, YELLOW, WHITE, DASHES[2], SAND, "posts", CLEAR)),
    "hazel": Design(4, 3, True, Look(134, 20, WHITE, WHITE, DASHES[0], SNOW, "trees", HAZE)),
    "larch": Design(5, 2, False, Look(84, 16, YELLOW, YELLOW, DASHES[2], GRASS, "houses", DUSK)),
    "maple": Design(6, 4, True, Look(108, 12, WHITE, YELLOW, DASHES[1], SAND, "trees", DUSK)),
    "rowan": Design(7, 3, False, Look(124, 16, YELLOW, WHITE, DASHES[1], MEADOW, "posts", CLEAR)),
}
TEST = {
    "spruce": Design(11, 3, True, Look(100, 16, WHITE, WHITE, DASHES[2], MEADOW, "trees", CLEAR)),
    "willow": Design(12, 2, False, Look(88, 12, YELLOW, WHITE, DASHES[0], GRASS, "posts", HAZE)),
    "yew": Design(13, 4, True, Look(126, 18, WHITE, YELLOW, DASHES[1], SAND, "houses", CLEAR)),
}


@lru_cache(maxsize=64)  # a measure goes around 40 of them
def make_track(name: str) -> Track:
    """Build a track by its name: one of TRAINING or TEST, or `random:<seed>`, any other member of
    the family.

    Raises:
        ValueError: no such track.
    """
    if name.startswith(RANDOM_PREFIX) and name[len(RANDOM_PREFIX) :].isdecimal():
        return _build(name, _random_design(int(name[len(RANDOM_PREFIX) :])))
    designs = TRAINING | TEST
    if name not in designs:
        raise ValueError(
            f"track {name!r}: expected one of {', '.join(designs)} or {RANDOM_PREFIX}<seed>"
        )
    return _build(name, designs[name])


def _build(name: str, design: Design) -> Track:
    rng = np.random.default_rng([design.seed, 0])
    centreline = random_centreline(rng, rng.uniform(*TIGHTEST), design.clockwise)
    return Track(name, centreline, design.lanes, design.look, design.seed)


def _random_design(seed: int) -> Design:
    """A track nobody has named: every choice is drawn from what the training tracks show."""
    rng = np.random.default_rng([seed, 1])
    looks = [design.look for design in TRAINING.values()]

    def pick(field: str) -> Any:
        return getattr(looks[rng.integers(len(looks))], field)

    look = Look(
        asphalt=int(rng.integers(min(x.asphalt for x in looks), max(x.asphalt for x in looks) + 1)),
        grain=int(rng.integers(min(x.grain for x in looks), max(x.grain for x in looks) + 1)),
        line=pick("line"),
        edge=pick("edge"),
        dash=pick("dash"),
        ground=pick("ground"),
        props=pick("props"),
        sky=pick("sky"),
    )
    return Design(1000 + seed, int(rng.integers(2, 5)), bool(rng.integers(2)), look)
