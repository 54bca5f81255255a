"""Equal data is equal bytes, so that DVC runs nothing twice and stores nothing twice."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from pipeline.data.canonical import canonicalise
from pipeline.data.merging import merge
from pipeline.data.writing import write_dataset
from tests.data.conftest import strict_json, tree
from tests.data.sample import write_sample
from tests.episodes import random_episode


def test_bytes_depend_on_neither_place_nor_hash_seed(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "somewhere" / "else"
    # first in this directory, so that both processes import LeRobot at the same time
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


def test_merging_keeps_the_data_files_of_the_first(d_0: Path, rollout_1: Path, tmp_path: Path):
    merge([d_0, rollout_1], tmp_path / "D_1")
    then = random_episode(np.random.default_rng(2), 3, iteration=2)
    write_dataset(tmp_path / "rollout_2", [then], record_every=3)
    merge([tmp_path / "D_1", tmp_path / "rollout_2"], tmp_path / "D_2")
    d_1, d_2 = tree(tmp_path / "D_1" / "data"), tree(tmp_path / "D_2" / "data")
    assert len(d_1) == 2
    assert len(d_2) == 3
    assert tree(d_0 / "data").items() <= d_1.items() <= d_2.items()


def test_canonicalising_twice_changes_nothing(d_0: Path, rollout_1: Path, tmp_path: Path) -> None:
    merge([d_0, rollout_1], tmp_path / "D_1")
    before = tree(tmp_path / "D_1")
    canonicalise(tmp_path / "D_1")
    assert tree(tmp_path / "D_1") == before


def test_statistics_do_not_tell_how_a_dataset_came_about(
    d_0: Path, rollout_1: Path, tmp_path: Path
) -> None:
    merge([d_0], tmp_path / "same")
    before, after = (strict_json(path / "meta" / "stats.json") for path in (d_0, tmp_path / "same"))
    assert before == after
