"""What stands beside the experiment, read for every seed that it has."""

import json
import shutil
from pathlib import Path

import pytest

from pipeline.report.material import ErrorShares, read_material
from tests.evaluation.sample import drives, write_run


def write_seed(metrics: Path, seed: int) -> Path:
    """A seed with DAgger, another threshold and a primary from scratch."""
    folder = write_run(metrics / f"seed_{seed}")
    for file in sorted(folder.glob("*_safedagger_?.*")):
        shutil.copy(file, folder / file.name.replace("safedagger", "dagger"))
    for kind in ("drives_{}.csv", "safety_{}.json"):
        shutil.copy(folder / kind.format("safedagger_1"), folder / kind.format("tau_01"))
    text = (folder / "safety_tau_01.json").read_text()
    (folder / "safety_tau_01.json").write_text(text.replace("0.0025", "0.01"))
    shutil.copy(folder / "drives_safedagger_2.csv", folder / "drives_scratch_3.csv")
    return folder


def test_every_seed_has_its_own(tmp_path: Path) -> None:
    write_seed(tmp_path, 3)
    folder = write_run(tmp_path / "seed_1")
    ledger = folder / "ledger_D_safe.json"
    ledger.write_text(ledger.read_text().replace("1201", "700"))
    found = read_material(tmp_path)
    assert {seed: each.queries for seed, each in found.d_safe.items()} == {1: 700, 3: 1201}
    assert found.errors == dict.fromkeys((1, 3), ErrorShares(0.0025, 0.95, 0.8, 0.777, 0.0018))
    assert list(found.thresholds) == [0.0025, 0.01]
    assert found.scratch.seeds == [3]


def test_what_was_driven_is_counted_once(tmp_path: Path) -> None:
    """Iteration 0 stands for both runs, and beside the other threshold."""
    write_seed(tmp_path, 0)
    driven = read_material(tmp_path).driven
    loops = [f"{run}_{i}" for run in ("dagger", "safedagger") for i in (1, 2, 3)]
    assert set(driven.step) == {"0", *loops, "scratch_3", "tau_01"}
    assert len(driven) == len(drives(0)) * 9


def test_a_seed_without_errors_has_none(tmp_path: Path) -> None:
    write_run(tmp_path / "seed_0")
    (write_run(tmp_path / "seed_1") / "errors.json").unlink()
    assert read_material(tmp_path).errors.keys() == {0}


def test_errors_that_were_judged_without_a_share(tmp_path: Path) -> None:
    path = write_run(tmp_path / "seed_0") / "errors.json"
    content = json.loads(path.read_text())
    del content["share"], content["held_out"]["tau_for_share"]
    path.write_text(json.dumps(content))
    assert read_material(tmp_path).errors[0] == ErrorShares(0.0025, 0.95, 0.8, None, None)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    (write_run(tmp_path / "seed_0") / "ledger_D_safe.json").unlink()
    with pytest.raises(FileNotFoundError, match=r"seed_0/ledger_D_safe.json: no such file"):
        read_material(tmp_path)
