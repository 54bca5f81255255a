"""Reading the safety policies of several tau: by tau, on every seed, beside iteration 0's own."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.drives import write_drives
from pipeline.report.threshold import RUN, read_thresholds
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import drives, write_run

TAUS = {"tau_000625": 0.000625, "tau_01": 0.01, "tau_04": 0.04}


def write_seed(metrics: Path, seed: int, *names: str) -> Path:
    """A seed with safety policies of other thresholds, driven like iterations 1, 2, ..."""
    folder = write_run(metrics / f"seed_{seed}")
    for iteration, name in enumerate(names, 1):
        shutil.copy(folder / f"drives_safedagger_{iteration}.csv", folder / f"drives_{name}.csv")
        safety = json.loads((folder / "safety_0.json").read_text()) | {"tau": TAUS[name]}
        safety["held_out"]["share_unsafe"] = iteration / 10
        (folder / f"safety_{name}.json").write_text(json.dumps(safety))
    return folder


def test_all_seeds_are_read_by_tau(tmp_path: Path) -> None:
    write_seed(tmp_path, 10, "tau_04", "tau_000625")
    write_seed(tmp_path, 2, "tau_04")
    found = read_thresholds(tmp_path)
    assert list(found) == [0.000625, 0.0025, 0.04]
    assert [found[tau].seeds for tau in found] == [[10], [2, 10], [2, 10]]
    (step,) = found[0.000625].of(RUN, 0)
    assert step.held_out.share_unsafe == 0.2
    pd.testing.assert_frame_equal(step.drives, drives(2))
    for step in found[0.0025].of(RUN, 0):
        pd.testing.assert_frame_equal(step.drives, drives(0))


def test_another_primary_is_not_compared(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "tau_01", "tau_04")
    (folder / "drives_tau_04.csv").unlink()
    write_drives(folder / "drives_tau_04.csv", drives(1).assign(primary="f" * 64))
    assert list(read_thresholds(tmp_path)) == [0.0025, 0.01]


def test_what_was_read_can_be_measured(tmp_path: Path) -> None:
    write_seed(tmp_path, 0, "tau_01")
    cell = Cell(RUN, (0,), Strategy.SAFE, ("traffic",))
    takeovers = [estimate(each, "takeover", cell) for each in read_thresholds(tmp_path).values()]
    assert [round(each.value, 2) for each in takeovers if each] == [0.4, 0.3]


def test_seeds_without_other_thresholds_are_left_out(tmp_path: Path) -> None:
    write_seed(tmp_path, 0)
    assert read_thresholds(tmp_path) == {}
    write_seed(tmp_path, 1, "tau_01")
    assert [each.seeds for each in read_thresholds(tmp_path).values()] == [[1], [1]]


def test_other_names_are_left_alone(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "tau_01")
    shutil.copy(folder / "drives_tau_01.csv", folder / "drives_tau_high.csv")
    shutil.copytree(folder, tmp_path / "seed_old")
    found = read_thresholds(tmp_path)
    assert [(tau, each.seeds) for tau, each in found.items()] == [(0.0025, [0]), (0.01, [0])]


@pytest.mark.parametrize("name", ["safety_tau_01.json", "safety_0.json", "ledger_D_0.json"])
def test_a_missing_companion_is_named(tmp_path: Path, name: str) -> None:
    (write_seed(tmp_path, 0, "tau_01") / name).unlink()
    with pytest.raises(FileNotFoundError, match=rf"seed_0/{name}: no such file, expected"):
        read_thresholds(tmp_path)


def test_a_tau_that_a_seed_has_twice_is_refused(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "tau_01")
    for kind in ("drives_{}.csv", "safety_{}.json"):
        shutil.copy(folder / kind.format("tau_01"), folder / kind.format("tau_010"))
    with pytest.raises(
        ValueError, match=r"drives_tau_010.csv: tau is 0.01 again, expected another"
    ):
        read_thresholds(tmp_path)
