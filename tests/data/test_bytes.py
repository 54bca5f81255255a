"""Equal data is equal bytes, so that DVC runs nothing twice and stores nothing twice."""

import os
import subprocess
import sys
from pathlib import Path

from pipeline.data.dataset import DRIVES, Dataset
from pipeline.data.lineage import FILE
from pipeline.data.selecting import sample
from tests.data.sample import write_sample
from tests.files import tree


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


def test_what_passes_through_stays_byte_for_byte(new_1: Dataset, tmp_path: Path) -> None:
    """All of it kept: the same rows, statistics and tasks, and another lineage."""
    sample(new_1, tmp_path / "all", len(new_1), seed=0)
    before, after = tree(new_1.path), tree(tmp_path / "all")
    before.pop(DRIVES, None)
    del before[FILE], after[FILE]
    assert after == before
