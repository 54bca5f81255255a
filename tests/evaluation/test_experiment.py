"""Reading every seed and run: what is missing is named."""

import json
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.evaluation.drives import read_drives, write_drives
from pipeline.evaluation.experiment import Experiment, read_experiment
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import CARS, COMPARISON, TRACKS, drives, write_run


def write_seed(metrics: Path, seed: int, *others: str) -> Path:
    """SafeDAgger's run of a seed, and other runs that went as well."""
    folder = write_run(metrics / f"seed_{seed}")
    for run in others:
        for file in sorted(folder.glob("*_safedagger_?.*")):
            shutil.copy(file, folder / file.name.replace("safedagger", run))
    return folder


def test_every_seed_and_run_is_read(tmp_path: Path) -> None:
    write_seed(tmp_path, 10, "dagger_budget", "supervised")
    write_seed(tmp_path, 2)
    experiment = read_experiment(tmp_path)
    assert experiment.seeds == [2, 10]
    assert experiment.runs == ["safedagger", "dagger_budget", "supervised"]
    assert experiment.iterations("dagger_budget") == [0, 1, 2, 3]
    assert experiment.iterations("dagger") == []
    assert [step.seed for step in experiment.of("safedagger", 1)] == [2, 10]
    assert [step.seed for step in experiment.of("supervised", 1)] == [10]
    step = experiment.steps[10, "supervised", 2]
    assert (step.seed, step.run, step.iteration) == (10, "supervised", 2)
    pd.testing.assert_frame_equal(step.drives, drives(2))
    assert step.name == "supervised_2"
    assert step.ledger.queries == 800
    assert step.held_out.auroc == 0.9
    assert step.tau == 0.0025


def test_rollouts_belong_to_the_policies_that_drove_them(tmp_path: Path) -> None:
    """Those of other strategies than SafeDAgger's know no safety policy."""
    write_seed(tmp_path, 0, "safedagger_last", "dagger")
    experiment = read_experiment(tmp_path)
    for run in ("safedagger", "safedagger_last"):
        steps = [experiment.steps[0, run, i] for i in range(4)]
        recalls = [step.next_rollout and step.next_rollout.recall for step in steps]
        assert recalls == [pytest.approx(0.48), pytest.approx(0.46), pytest.approx(0.44), None]
    assert {experiment.steps[0, "dagger", i].next_rollout for i in range(4)} == {None}


def test_drives_are_told_apart_by_strategy_and_condition(tmp_path: Path) -> None:
    write_seed(tmp_path, 0)
    found = read_experiment(tmp_path)
    here = {"run": "safedagger", "iteration": 1, "condition": "traffic"}
    safe = found.among(**here, strategy=Strategy.SAFE)
    assert len(safe) == 2 * len(TRACKS)
    assert set(safe.traffic) == {CARS} and set(safe.strategy) == {"safe"}
    assert found.among(**here, strategy=Strategy.OPTIMAL).empty


def test_the_queries_are_those_of_the_loop_so_far(tmp_path: Path) -> None:
    write_seed(tmp_path, 0)
    experiment = read_experiment(tmp_path)
    so_far = [experiment.queries(0, "safedagger", i) for i in range(4)]
    assert so_far == [0, 1100, 1900, 2400]


def test_iteration_0_is_shared_unless_a_run_has_its_own(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "safedagger_last")
    safety = json.loads((folder / "safety_0.json").read_text())
    safety["held_out"]["auroc"] = 0.7
    (folder / "safety_safedagger_last_0.json").write_text(json.dumps(safety))
    shutil.copy(folder / "drives_0.csv", folder / "drives_safedagger_last_0.csv")
    steps = read_experiment(tmp_path).steps
    assert steps[0, "safedagger_last", 0].held_out.auroc == 0.7
    assert steps[0, "safedagger", 0].held_out.auroc == 0.9
    assert steps[0, "safedagger_last", 0].ledger == steps[0, "safedagger", 0].ledger


def test_what_is_no_run_or_seed_is_left_alone(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "tau", "scratch")
    shutil.copytree(folder, tmp_path / "seed_old")
    write_run(tmp_path)
    experiment = read_experiment(tmp_path)
    assert (experiment.seeds, experiment.runs) == ([0], ["safedagger"])


@pytest.mark.parametrize(
    "name",
    [
        "drives_0.csv",
        "drives_dagger_1.csv",
        "ledger_D_dagger_2.json",
        "safety_safedagger_3.json",
        "rollout_safedagger_2.json",
    ],
)
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    (write_seed(tmp_path, 0, "dagger") / name).unlink()
    with pytest.raises(FileNotFoundError, match=rf"seed_0/{name}: no such file, expected"):
        read_experiment(tmp_path)


@pytest.mark.parametrize("folders", [[], ["seed_0"], ["seed_0", "seed_1"]])
def test_no_results_are_refused(tmp_path: Path, folders: list[str]) -> None:
    for folder in folders:
        (tmp_path / folder).mkdir()
    with pytest.raises(ValueError, match=r"no seed_<n>/drives_<run>_<i>.csv, expected some"):
        read_experiment(tmp_path)


def test_runs_come_in_the_order_in_which_they_were_told(tmp_path: Path) -> None:
    write_seed(tmp_path, 0, "supervised", "dagger_budget")
    found = read_experiment(tmp_path)
    assert found.runs == [run for run in COMPARISON.runs if run in found.runs]
    assert found.ours == "safedagger"
    assert found.strategies == ["safedagger", "dagger", "dagger_budget", "supervised"]
    assert found.variants[0] == "safedagger" and len(found.variants) == 4
    assert Experiment({}, {}).runs == [] and Experiment({}, {}).ours is None


def test_drives_of_a_run_that_nobody_knows_are_refused(tmp_path: Path) -> None:
    write_seed(tmp_path, 0, "dager")
    with pytest.raises(ValueError, match=r"seed_0: drives of a run 'dager', expected one of safed"):
        read_experiment(tmp_path)


def test_a_run_need_be_told_on_one_seed_only(tmp_path: Path) -> None:
    """A seed that was run again by default, on one on which all had been compared."""
    write_seed(tmp_path, 0, "dagger")
    write_seed(tmp_path, 1)
    tell(tmp_path / "seed_0", runs=["safedagger"], from_scratch=[], driven_by="naive")
    found = read_experiment(tmp_path)
    assert (found.runs, found.left_out) == (["safedagger", "dagger"], ())


def test_what_was_told_something_else_is_left_out(tmp_path: Path) -> None:
    for seed in (0, 1):
        write_seed(tmp_path, seed, "dagger")
    tell(tmp_path / "seed_1", samples=[7])
    found = read_experiment(tmp_path)
    assert {key[:2] for key in found.steps} == {
        (0, "safedagger"), (0, "dagger"), (1, "dagger")
    }  # fmt: skip
    assert found.left_out == ("SafeDAgger, seed 1: told something else than elsewhere.",)


def test_what_began_with_another_primary_is_left_out(tmp_path: Path) -> None:
    """SafeDAgger was run again on another processor: its first primary is another there."""
    folder = write_seed(tmp_path, 0, "dagger")
    write_seed(tmp_path, 1, "dagger")
    for file in (folder / "drives_0.csv", *folder.glob("drives_safedagger_*.csv")):
        write_drives_again(file, begun_with="f" * 64)
    found = read_experiment(tmp_path)
    assert {key[:2] for key in found.steps} == {
        (0, "safedagger"), (1, "safedagger"), (1, "dagger")
    }  # fmt: skip
    assert found.left_out == ("DAgger, seed 0: began with another primary.",)


def tell(folder: Path, runs: Iterable[str] | None = None, **changes: Any) -> None:
    """Other runs, or another SafeDAgger."""
    told = json.loads((folder / "runs.json").read_text())
    told["runs"]["safedagger"] |= changes
    told["runs"] = {name: told["runs"][name] for name in runs or told["runs"]}
    (folder / "runs.json").write_text(json.dumps(told))


def write_drives_again(file: Path, **changes: Any) -> None:
    found = read_drives(file).assign(**changes)
    file.unlink()
    write_drives(file, found)
