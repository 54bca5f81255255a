from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.labels import check_labels
from pipeline.data.selecting import select
from tests.episodes import random_episode, write


def test_what_the_reference_drove_and_what_was_selected_is_labelled(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    check_labels(d_0)
    select(rollout_1, tmp_path / "new")
    check_labels(Dataset.open(tmp_path / "new"))


def test_a_raw_rollout_is_not(rollout_1: Dataset) -> None:
    unlabelled = int((~rollout_1.column("queried")).sum())
    assert unlabelled
    message = f"^{rollout_1.path}: {unlabelled} frames have no label of the reference, .* select"
    with pytest.raises(ValueError, match=message):
        check_labels(rollout_1)


def test_a_frame_that_was_asked_is_labelled_whoever_drove(tmp_path: Path) -> None:
    """DAgger's, whose reference need not drive at all."""
    drive = random_episode(np.random.default_rng(0), 3)
    drive.columns["intervention"][:], drive.columns["queried"][:] = False, True
    check_labels(write(tmp_path / "dagger", [drive]))


def test_nothing_is_nothing_to_learn_from(tmp_path: Path) -> None:
    drive = random_episode(np.random.default_rng(0), 2)
    drive.columns["queried"][:] = False
    select(write(tmp_path / "rollout", [drive]), tmp_path / "new")
    with pytest.raises(ValueError, match="new: no frames, expected some to learn from"):
        check_labels(Dataset.open(tmp_path / "new"))
