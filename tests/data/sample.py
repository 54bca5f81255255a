"""Write three datasets, always the same: python -m tests.data.sample DIRECTORY."""

import sys
from pathlib import Path

import numpy as np

from pipeline.data.merging import merge
from tests.episodes import random_episode, write


def write_sample(root: Path) -> None:
    """D_0, selected_1 and their union D_1, on several tracks, with NaN, at `root`."""
    rng = np.random.default_rng(3)
    tracks = ("coast", "hills", "forest")
    first = [random_episode(rng, 3, task=track, reference_only=True) for track in tracks]
    then = [random_episode(rng, n, task=track, iteration=1) for n, track in enumerate(tracks, 1)]
    d_0 = write(root / "D_0", first)
    selected = write(root / "selected_1", reversed(then), "select")
    merge([d_0, selected], root / "D_1")


if __name__ == "__main__":
    write_sample(Path(sys.argv[1]))
