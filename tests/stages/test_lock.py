"""The committed dvc.lock."""

from pathlib import Path

import yaml
from dvc.repo import Repo

HOUSE = Path(__file__).parents[2]


def test_the_committed_lock_is_of_the_committed_pipeline() -> None:
    """Else: `make repro`, so that whoever repeats it can compare what comes out, byte for byte."""
    with Repo(HOUSE) as repo:
        called = {stage.name: stage.cmd for stage in repo.stage.load_all("dvc.yaml")}
    locked = yaml.safe_load((HOUSE / "dvc.lock").read_text())["stages"]
    assert {name: stage["cmd"] for name, stage in locked.items()} == called
