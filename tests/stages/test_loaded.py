"""No stage imports what it does not use: LeRobot takes seconds to import, and so does PyTorch."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from tests.episodes import random_episode, write
from tests.evaluation.written import write_run

HOUSE = Path(__file__).parents[2]
HEAVY = ("lerobot", "datasets", "torch", "pybullet", "cv2", "matplotlib", "scipy")

# What one process has loaded after each of several commands, the lightest first.
CODE = f"""
import json, sys
from stages.__main__ import commands
for words in json.loads(sys.argv[1]):
    commands(words)(words, standalone_mode=False)
    print("LOADED", words[0], *(name for name in {HEAVY} if name in sys.modules))
"""


def test_commands_load_what_they_use(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write(tmp_path / "D_0", [random_episode(rng, 4, reference_only=True)])
    write(tmp_path / "rollout", [random_episode(rng, 9, iteration=1)], "rollout")
    write_run(tmp_path / "metrics")
    params = f"--params {HOUSE}/params.yaml --pipeline {HOUSE}/dvc.yaml --loops loops.yaml"
    ours, driving = set(), {"pybullet", "cv2", "scipy"}
    expected = {
        f"plan {params}": ours,
        f"runs {params} --metrics runs.json": ours,
        "select rollout new": ours,
        "sample rollout some --frames 3 --seed 0": ours,
        "merge D_0 new D_1": ours,
        "ledger rollout D_1 --metrics ledger.json": ours,
        "results metrics": ours,
        "collect more --tracks alder --seconds 0.1 --episodes 1 --workers 1": driving,
        "contact-sheet rollout sheet.png --frames 1": driving | {"matplotlib"},
        "report --metrics metrics --errors metrics --frames metrics --output report.md --figures png": (
            driving | {"matplotlib"}
        ),
    }
    done = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps([words.split() for words in expected])],
        cwd=tmp_path,
        env={"PYTHONPATH": str(HOUSE)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if line.startswith("LOADED")]
    for (command, allowed), (_, name, *loaded) in zip(expected.items(), lines, strict=True):
        assert command.startswith(name)
        assert set(loaded) <= allowed, name
