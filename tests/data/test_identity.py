from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.identity import identities, refuse_shared
from tests.episodes import random_episode, write


def test_no_two_frames_of_a_dataset_are_the_same(rollout_1: Dataset) -> None:
    assert len(set(identities(rollout_1))) == len(identities(rollout_1)) == 10


def test_a_selected_frame_is_still_the_same(rollout_1: Dataset, new_1: Dataset) -> None:
    assert set(identities(new_1)) < set(identities(rollout_1))
    message = f"{rollout_1.path}: {len(new_1)} of its frames are in {new_1.path} too"
    with pytest.raises(ValueError, match=message):
        refuse_shared(new_1, rollout_1)


def test_drives_of_one_number_in_other_datasets_are_others(tmp_path: Path) -> None:
    """D_0 and D_safe number their drives alike, and so do two seeds: even if all else is equal."""
    d_0, d_safe = (
        write(tmp_path / name, [random_episode(np.random.default_rng(0), 3)], name)
        for name in ("D_0", "D_safe")
    )
    refuse_shared(d_0, d_safe)
