"""Algorithm 1 for real, tiny: `dvc repro` from nothing, end to end, on the project's own dvc.yaml."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

HOUSE = Path(__file__).parents[2]
TINY = {
    "tracks": {"training": "alder,birch", "test": "yew"},
    "iterations": {
        "1": {"previous": "0", "queries": 12, "passes": 128},
        "2": {"previous": "1", "queries": 12, "passes": 128},
    },
    "trained": ["0", "1", "2"],
    "ledgers": {
        "D_0": {"raw": "D_0"},
        "D_safe": {"raw": "D_safe"},
        "D_1": {"raw": "rollout_1"},
        "D_2": {"raw": "rollout_2"},
    },
    "report": {"iterations": 2},
    "drive": {"traffic": 3},
    "d-0": {"episodes": 4, "seconds": 1},
    "d-safe": {"episodes": 4, "seconds": 1},
    "primary-0": {"passes": 192},
    "train-primary": {"channels": 4},
    "train-safety": {"passes": 256, "hidden": 8, "cut": 1.0},
    "rollout": {"frames": 60, "seconds": 2},
    "evaluate": {"traffic": 2, "laps": 0.05, "seconds": 2},
}


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout's pipeline with tiny parameters, reproduced."""
    root = tmp_path_factory.mktemp("house")
    for name in ("pipeline", "stages", "dvc.yaml"):
        (root / name).symlink_to(HOUSE / name)
    params = yaml.safe_load((HOUSE / "params.yaml").read_text())
    for group, values in TINY.items():
        keep = isinstance(values, dict) and group not in ("iterations", "ledgers")
        params[group] = params[group] | values if keep else values
    (root / "params.yaml").write_text(yaml.safe_dump(params))
    dvc(root, "init", "--no-scm")
    settings = (HOUSE / ".dvc" / "config").read_text()
    (root / ".dvc" / "config").write_text(settings.replace("[core]", "[core]\n    no_scm = true"))
    dvc(root, "repro")
    return root


def dvc(root: Path, *arguments: str) -> str:
    """What a DVC command prints; the stages it runs find this Python's commands first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [Path(sys.executable).parent / "dvc", *arguments],
        cwd=root,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def metric(house: Path, name: str) -> dict:
    return json.loads((house / "cards" / "metrics" / "seed_0" / f"{name}.json").read_text())


def test_what_was_selected_is_what_was_queried_is_what_was_merged(house: Path) -> None:
    from pipeline.data.reading import read_columns

    before = len(read_columns(house / "datasets" / "D_0")["episode_index"])
    for i in (1, 2):
        raw = read_columns(house / "datasets" / f"rollout_{i}")
        selected = read_columns(house / "datasets" / f"selected_{i}")
        after = len(read_columns(house / "datasets" / f"D_{i}")["episode_index"])
        queries = int(raw["queried"].sum())
        assert queries == len(selected["episode_index"]) == after - before
        assert metric(house, f"ledger_D_{i}")["queries"] == queries
        before = after


def test_the_report_stands_on_the_metrics(house: Path) -> None:
    report = (house / "cards" / "report.md").read_text()
    assert "D_safe" in report
    assert metric(house, "driving_2")["naive"]["traffic"]["laps"] >= 0


def test_a_second_repro_does_nothing(house: Path) -> None:
    assert "up to date" in dvc(house, "repro")


def test_a_change_in_iteration_2_runs_only_what_follows(house: Path) -> None:
    params = house / "params.yaml"
    before = params.read_text()
    params.write_text(
        before.replace("passes: 128", "passes: 64", 2).replace("passes: 64", "passes: 128", 1)
    )
    try:
        plan = dvc(house, "repro", "--dry")
    finally:
        params.write_text(before)
    stages = {line.split("'")[1] for line in plan.splitlines() if line.startswith("Running stage")}
    assert "train-primary@2" in stages
    assert not {name for name in stages if name.endswith(("@0", "@1", "_0", "-0"))}
