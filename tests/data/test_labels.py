from pathlib import Path

import pytest

from pipeline.data.labels import check_labels
from pipeline.data.reading import read_columns, read_episodes
from pipeline.data.selecting import select_unsafe
from pipeline.data.writing import write_dataset


def test_what_the_reference_drove_and_what_was_selected_is_labelled(
    d_0: Path, rollout_1: Path, tmp_path: Path
) -> None:
    check_labels(d_0)
    write_dataset(tmp_path / "new", select_unsafe(read_episodes(rollout_1), 0.5), record_every=3)
    check_labels(tmp_path / "new")


def test_a_raw_rollout_is_not(rollout_1: Path) -> None:
    unlabelled = int((~read_columns(rollout_1)["queried"]).sum())
    assert unlabelled
    message = f"^{rollout_1}: {unlabelled} frames have no label of the reference, .* select"
    with pytest.raises(ValueError, match=message):
        check_labels(rollout_1)
