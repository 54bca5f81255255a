"""Equal data is equal bytes, so that DVC runs nothing twice and stores nothing twice."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from pipeline.data.dataset import DRIVES, Dataset
from pipeline.data.lineage import FILE
from pipeline.data.merging import merge
from pipeline.data.selecting import sample
from tests.data.conftest import tree
from tests.data.sample import write_sample
from tests.episodes import random_episode, write


def test_bytes_depend_on_neither_place_nor_hash_seed(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "somewhere" / "else"
    with subprocess.Popen(
        [sys.executable, "-m", "tests.data.sample", str(there)],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "PYTHONHASHSEED": "12345"},
    ) as process:
        write_sample(here)
    assert process.returncode == 0
    files = tree(here)
    assert {Path(name).parts[0] for name in files} == {"D_0", "selected_1", "D_1"}
    assert files == tree(there)


def test_merging_keeps_the_data_files_of_the_first(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    merge([d_0, rollout_1], tmp_path / "D_1")
    then = random_episode(np.random.default_rng(2), 3, iteration=2)
    rollout_2 = write(tmp_path / "rollout_2", [then], "rollout")
    merge([Dataset.open(tmp_path / "D_1"), rollout_2], tmp_path / "D_2")
    d_1, d_2 = tree(tmp_path / "D_1" / "data"), tree(tmp_path / "D_2" / "data")
    assert len(d_1) == 2
    assert len(d_2) == 3
    assert tree(d_0.path / "data").items() <= d_1.items() <= d_2.items()


def test_what_passes_through_stays_byte_for_byte(rollout_1: Dataset, tmp_path: Path) -> None:
    """All of it kept: the same rows, statistics and tasks, and another lineage."""
    sample(rollout_1, tmp_path / "all", len(rollout_1), seed=0)
    before, after = tree(rollout_1.path), tree(tmp_path / "all")
    before.pop(DRIVES, None)
    del before[FILE], after[FILE]
    assert after == before
