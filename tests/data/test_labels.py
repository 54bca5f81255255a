from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.labels import labelled, told
from pipeline.data.schema import CORE, Asked
from pipeline.data.selecting import select
from tests.data.spoiling import copy, drop_column
from tests.episodes import random_episode, write


def test_what_the_reference_drove_is_labelled_and_its_episodes_are_the_runs(d_0: Dataset) -> None:
    runs, run = labelled(d_0)
    assert runs == d_0.bounds
    assert run.tolist() == d_0.episode_index.tolist()
    assert told(d_0) == []


def test_of_a_rollout_it_is_what_was_asked_whoever_drove(tmp_path: Path) -> None:
    """DAgger's reference need not drive at all; and no run goes on into the next episode."""
    reasons = [Asked.NOT] + [Asked.MIXTURE] * 3, [Asked.MIXTURE, Asked.NOT, Asked.MIXTURE]
    drives = [random_episode(np.random.default_rng(0), len(of), asked=of) for of in reasons]
    raw = write(tmp_path / "raw", drives)
    runs, run = labelled(raw)
    assert runs == [(1, 4), (4, 5), (6, 7)]
    assert run.tolist() == [0, 0, 0, 1, 2]
    assert told(raw) == [
        f"{raw.path}: 2 of 7 frames have no label of the reference, and are not learned from"
    ]


def test_what_is_labelled_is_what_is_selected(rollout_1: Dataset, tmp_path: Path) -> None:
    select(rollout_1, tmp_path / "new")
    new = Dataset.open(tmp_path / "new")
    runs, run = labelled(rollout_1)
    assert run.tolist() == new.episode_index.tolist() == labelled(new)[1].tolist()
    assert [stop - start for start, stop in runs] == new.lengths.tolist()


def test_nothing_is_nothing_to_learn_from(unasked: Dataset, nothing: Dataset) -> None:
    for dataset in (unasked, nothing):
        problem = f"^{dataset.path}: of {len(dataset)} frames none has a label"
        with pytest.raises(ValueError, match=problem):
            labelled(dataset)


def test_a_dataset_without_core_columns_is_demonstrations(
    rollout_1: Dataset, tmp_path: Path
) -> None:
    """One that has any is judged by what they tell."""
    path = copy(rollout_1, tmp_path / "plain")
    drop_column(*(name for name in CORE if name not in ("action", "safe_probability")))(path)
    with pytest.raises(ValueError, match="none has a label"):
        labelled(Dataset.open(path))
    drop_column("safe_probability")(path)
    plain = Dataset.open(path)
    assert labelled(plain)[0] == plain.bounds
    assert plain.column("intervention").all() and (plain.column("asked_because") == 0).all()
    (line,) = told(plain)
    assert line.endswith("so all 10 frames count as the reference's")
