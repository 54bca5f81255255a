"""The safest and the least safe frames of a dataset, with their probability (the paper's appendix).

In the shapes, N is the number of frames.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray

from pipeline.inspection.canvas import new_figure

COLUMNS = 5  # frames beside each other


@dataclass(frozen=True, eq=False)
class Shown:
    """A frame on the sheet."""

    image: NDArray[np.uint8]
    """[H, W, 3]"""
    safe_probability: float
    episode: int
    frame: int
    """counted within the episode"""


def extreme_frames(
    safe_probability: NDArray[np.floating], episode_index: NDArray[np.int64], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of the `count` safest and of the `count` least safe frames, most extreme first; ValueError
    where fewer have a probability.

    Neighbours look alike, so that an episode gives one frame to each, or more only where there are
    fewer than `count` episodes. Both columns are [N]; `safe_probability` is NaN where there is none.
    """
    known = np.flatnonzero(~np.isnan(safe_probability))
    if not 1 <= count <= len(known):
        raise ValueError(f"{len(known)} frames have a safe probability, expected at least {count}")
    rising = known[np.argsort(safe_probability[known], kind="stable")]
    return _one_each(rising[::-1], episode_index, count), _one_each(rising, episode_index, count)


def contact_sheet(title: str, safest: Sequence[Shown], least_safe: Sequence[Shown]) -> Figure:
    """Two panels of frames, each with its probability of being safe and its place; ValueError without any."""
    panels = {"Safest frames": safest, "Least safe frames": least_safe}
    rows = [-(-len(frames) // COLUMNS) for frames in panels.values()]
    if 0 in rows:
        raise ValueError("there are no frames, expected some safe and some unsafe ones")
    with new_figure(2.2 * COLUMNS, 1.4 * sum(rows) + 1.1) as figure:
        figure.suptitle(title, fontsize=11, fontweight="bold")
        halves = figure.add_gridspec(2, 1, height_ratios=rows)
        for half, (name, frames) in enumerate(panels.items()):
            _draw(figure.add_subfigure(halves[half]), name, frames, rows[half])
    return figure


def _one_each(
    ranked: NDArray[np.int64], episode_index: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """The first `count` of `ranked`, those that are the first of their episode before others."""
    _, firsts = np.unique(episode_index[ranked], return_index=True)
    others = np.setdiff1d(np.arange(len(ranked)), firsts)
    return ranked[np.concatenate([np.sort(firsts), others])[:count]]


def _draw(panel: SubFigure, name: str, frames: Sequence[Shown], rows: int) -> None:
    panel.suptitle(name, fontsize=10, x=0.01, ha="left")
    grid = panel.subplots(rows, COLUMNS, squeeze=False).ravel()
    for axes in grid:
        axes.set_axis_off()
    for axes, shown in zip(grid, frames, strict=False):
        axes.imshow(shown.image, interpolation="nearest")
        probability = f"{shown.safe_probability:.3f}"
        axes.set_title(probability, fontsize=8, pad=2, loc="center", fontweight="normal")
        place = f"episode {shown.episode}, frame {shown.frame}"
        axes.text(0.5, -0.03, place, transform=axes.transAxes, fontsize=7, ha="center", va="top")
