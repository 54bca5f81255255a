from pathlib import Path

import numpy as np
import pytest

from pipeline.data.identity import identities, refuse_shared
from pipeline.data.reading import read_episodes
from pipeline.data.selecting import select_unsafe
from pipeline.data.writing import write_dataset
from tests.episodes import random_episode


def test_no_two_frames_of_a_dataset_are_the_same(rollout_1: Path) -> None:
    assert len(set(identities(rollout_1))) == len(identities(rollout_1)) == 10


def test_a_selected_frame_is_still_the_same(rollout_1: Path, tmp_path: Path) -> None:
    write_dataset(tmp_path / "new", select_unsafe(read_episodes(rollout_1), 0.5), record_every=3)
    selected = identities(tmp_path / "new")
    assert set(selected) < set(identities(rollout_1))
    message = f"{rollout_1}: {len(selected)} of its frames are in {tmp_path / 'new'} too"
    with pytest.raises(ValueError, match=message):
        refuse_shared(tmp_path / "new", rollout_1)


def test_drives_of_one_number_that_were_driven_elsewhere_are_others(tmp_path: Path) -> None:
    """D_0 and D_safe number their drives alike, and so do two seeds."""
    rng = np.random.default_rng(0)
    for name in ("D_0", "D_safe"):
        write_dataset(tmp_path / name, [random_episode(rng, 3)], record_every=3)
    refuse_shared(tmp_path / "D_0", tmp_path / "D_safe")
