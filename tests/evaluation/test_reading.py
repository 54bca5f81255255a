"""Reading every seed and run: what is missing is named."""

import json
import math
import shutil
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.drives import among, read_drives, write_drives
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, ROLLOUT, Experiment
from pipeline.evaluation.reading import (
    SCRATCH,
    WARM,
    read_errors,
    read_experiment,
    read_scratch,
    read_thresholds,
)
from pipeline.evaluation.writing import write_rows
from pipeline.metric import SPENT
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import COMPARISON, drives, write_run

TAUS = {"tau_000625": 0.000625, "tau_01": 0.01, "tau_010": 0.01, "tau_04": 0.04}


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
    assert experiment.seeds_of("safedagger", 1) == [2, 10]
    assert experiment.seeds_of("supervised", 1) == [10]
    here = {"seed": 10, "run": "supervised", "iteration": 2, "step": "supervised_2"}
    found = experiment.among(**here).drop(columns=[*here, "task.name"])
    expected = drives(2).assign(**{"task.laps": 3.0})
    pd.testing.assert_frame_equal(found.reset_index(drop=True), expected)
    assert among(experiment.ledgers, **here).queries.tolist() == [800]
    judged = among(experiment.quality, **here)
    assert judged[["judged_on", "auroc", "tau"]].values.tolist() == [["held_out", 0.9, 0.0025]]
    assert (experiment.conditions, experiment.most(METRICS["laps"])) == (
        ["no_traffic", "traffic"],
        3,
    )
    assert experiment.most(METRICS["takeover"]) == math.inf


def test_rollouts_belong_to_the_policies_that_drove_them(tmp_path: Path) -> None:
    """Those of other strategies than SafeDAgger's know no safety policy."""
    write_seed(tmp_path, 0, "safedagger_last", "dagger")
    found = among(read_experiment(tmp_path).quality, judged_on=ROLLOUT)
    assert set(found.run) == {"safedagger", "safedagger_last"}
    for _, rows in found.groupby("run"):
        assert rows.iteration.tolist() == [0, 1, 2]
        assert rows.recall.tolist() == pytest.approx([0.48, 0.46, 0.44])


def test_what_was_spent_is_that_of_the_loop_so_far(tmp_path: Path) -> None:
    """And the labels in all: D_0, the loop, D_safe where a loop needs it for a safety policy."""
    write_seed(tmp_path, 0, "dagger")
    found = read_experiment(tmp_path)
    spent = found.spent
    ours, dagger = (among(spent, run=run) for run in ("safedagger", "dagger"))
    assert ours.queries.tolist() == dagger.queries.tolist() == [0, 1100, 1900, 2400]
    assert ours.frames_driven.tolist() == [0, 3610, 7230, 10860]
    assert ours.frames_trained.tolist() == [3600, 4700, 5500, 6000]
    assert ours.takeover[1:].tolist() == pytest.approx(
        [1100 / 3610, 1900 / 7230, 2400 / 10860], rel=1e-5
    )
    assert ours.labels.tolist() == [4801, 5901, 6701, 7201]
    assert dagger.labels.tolist() == [3600, 4700, 5500, 6000]
    aside = found.specs["safedagger"].model_copy(update={"set_aside": 0.2})
    without = replace(found, specs={**found.specs, "safedagger": aside}).spent
    assert among(without, run="safedagger").labels.tolist() == [3600, 4700, 5500, 6000]


def test_what_older_ledgers_did_not_count_is_unknown(tmp_path: Path) -> None:
    """From there on; what newer ones count is summed, the failures of each kind by their names."""
    folder = write_seed(tmp_path, 0)
    counted = {"calls": 5, "failures": 3, "failures.touches": 2, "scenarios": 7}
    for iteration in (1, 2):
        path = folder / f"ledger_D_safedagger_{iteration}.json"
        (row,) = json.loads(path.read_text())["rows"]
        write_rows(path, row | counted, SPENT)
    spent = read_experiment(tmp_path).spent.set_index("iteration").query("run == 'safedagger'")
    for name, expected in (
        ("calls", 10),
        ("failures", 6),
        ("failures.touches", 4),
        ("scenarios", 7),
    ):
        assert spent[name][2] == expected
        assert math.isnan(spent[name][3])
    assert spent.queries.notna().all() and spent.put_back[1:].isna().all()


def test_iteration_0_is_shared_unless_a_run_has_its_own(tmp_path: Path) -> None:
    folder = write_seed(tmp_path, 0, "safedagger_last")
    for kind in ("safety_{}.json", "driving_{}.json", "drives_{}.csv"):
        shutil.copy(folder / kind.format("0"), folder / kind.format("safedagger_last_0"))
    text = (folder / "safety_0.json").read_text()
    (folder / "safety_safedagger_last_0.json").write_text(text.replace("0.9", "0.7"))
    found = read_experiment(tmp_path)
    first = among(found.quality, iteration=0, judged_on=HELD_OUT).set_index("run")
    assert first.auroc.to_dict() == {"safedagger": 0.9, "safedagger_last": 0.7}
    assert among(found.ledgers, iteration=0, step="safedagger_last_0").queries.tolist() == [3600]


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
        "driving_safedagger_3.json",
        "ledger_D_safe.json",
        "rollout_safedagger_2.json",
    ],
)
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    (write_seed(tmp_path, 0, "dagger") / name).unlink()
    with pytest.raises(FileNotFoundError, match=rf"seed_0/{name}: no such file, expected"):
        read_experiment(tmp_path)


def test_drives_in_a_condition_of_which_nothing_is_known_are_refused(tmp_path: Path) -> None:
    file = write_seed(tmp_path, 0) / "driving_safedagger_1.json"
    file.write_text(file.read_text().replace('"traffic"', '"rain"'))
    with pytest.raises(ValueError, match=r"_1.json: no row of condition 'traffic', expected one"):
        read_experiment(tmp_path)


def test_without_a_number_of_laps_there_is_no_end_to_them(tmp_path: Path) -> None:
    for file in write_seed(tmp_path, 0).glob("driving_*.json"):
        file.write_text(file.read_text().replace('"laps": 3.0', '"laps": null'))
    assert read_experiment(tmp_path).most(METRICS["laps"]) == math.inf


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
    nothing = Experiment(specs={})
    assert nothing.runs == [] and nothing.ours is None


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
    assert seeds_and_runs(found) == {(0, "safedagger"), (0, "dagger"), (1, "dagger")}
    assert found.left_out == ("SafeDAgger, seed 1: told something else than elsewhere.",)


def test_what_began_with_another_primary_is_left_out(tmp_path: Path) -> None:
    """SafeDAgger was run again on another processor: its first primary is another there."""
    folder = write_seed(tmp_path, 0, "dagger")
    write_seed(tmp_path, 1, "dagger")
    for file in (folder / "drives_0.csv", *folder.glob("drives_safedagger_*.csv")):
        write_drives_again(file, begun_with="f" * 64)
    found = read_experiment(tmp_path)
    assert seeds_and_runs(found) == {(0, "safedagger"), (1, "safedagger"), (1, "dagger")}
    assert found.left_out == ("DAgger, seed 0: began with another primary.",)


def seeds_and_runs(found: Experiment) -> set[tuple[int, str]]:
    """Of all tables, which have the same."""
    (there,) = {
        frozenset(zip(rows.seed, rows.run, strict=True)) - {(0, D_SAFE), (1, D_SAFE)}
        for rows in (found.drives, found.ledgers, found.quality)
    }
    return set(there)


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


def write_taus(metrics: Path, seed: int, *names: str) -> Path:
    """A seed with safety policies of other thresholds, driven like iterations 1, 2, ..."""
    folder = write_seed(metrics, seed)
    for iteration, name in enumerate(names, 1):
        for kind in ("drives_{}.csv", "driving_{}.json"):
            shutil.copy(folder / kind.format(f"safedagger_{iteration}"), folder / kind.format(name))
        safety = (folder / "safety_0.json").read_text().replace("0.0025", str(TAUS[name]))
        safety = safety.replace('"share_unsafe": 0.2', f'"share_unsafe": 0.{iteration}')
        (folder / f"safety_{name}.json").write_text(safety)
    return folder


def test_thresholds_of_all_seeds_are_read_by_tau(tmp_path: Path) -> None:
    write_taus(tmp_path, 10, "tau_04", "tau_000625")
    write_taus(tmp_path, 2, "tau_04")
    write_taus(tmp_path, 3)  # without other thresholds it is left out
    found = read_thresholds(tmp_path)
    seeds = {tau: found.seeds_of(tau, 0) for tau in set(found.drives.run)}
    assert seeds == {"0.000625": [10], "0.0025": [2, 10], "0.04": [2, 10]}
    assert among(found.quality, run="0.000625").share_unsafe.tolist() == [0.2]
    takeovers = [
        estimate(found, "takeover", Cell(tau, (0,), Strategy.SAFE, ("traffic",)))
        for tau in ("0.0025", "0.04", "0.000625")
    ]
    assert [round(each.value, 2) for each in takeovers if each] == [0.4, 0.3, 0.2]


def test_a_threshold_of_another_primary_is_not_compared(tmp_path: Path) -> None:
    write_drives_again(write_taus(tmp_path, 0, "tau_01") / "drives_tau_01.csv", primary="f" * 64)
    assert set(read_thresholds(tmp_path).drives.run) == {"0.0025"}


def test_a_tau_that_a_seed_has_twice_is_refused(tmp_path: Path) -> None:
    write_taus(tmp_path, 0, "tau_01", "tau_010")
    problem = r"drives_tau_010.csv: tau is 0.01 again, expected another"
    with pytest.raises(ValueError, match=problem):
        read_thresholds(tmp_path)


def write_scratch(folder: Path, name: str = "scratch_3") -> None:
    """As iteration 1 went."""
    for kind in ("drives_{}.csv", "driving_{}.json"):
        shutil.copy(folder / kind.format("safedagger_1"), folder / kind.format(name))


def test_the_warm_counterpart_stands_beside_the_primary_from_scratch(tmp_path: Path) -> None:
    write_scratch(write_seed(tmp_path, 4))
    found = read_scratch(tmp_path, read_experiment(tmp_path))
    assert set(zip(found.drives.run, found.drives.step, strict=True)) == {
        (WARM, "safedagger_3"),
        (SCRATCH, "scratch_3"),
    }
    assert found.among(run=SCRATCH).laps.tolist() == drives(1).laps.tolist()
    assert found.among(run=WARM).laps.tolist() == drives(3).laps.tolist()


@pytest.mark.parametrize(
    ("name", "changes"),
    [("scratch_7", {}), ("scratch_new", {}), ("scratch_3", {"begun_with": "f" * 64})],
    ids=["no counterpart", "no iteration", "another first primary"],
)
def test_what_cannot_be_compared_is_left_alone(
    tmp_path: Path, name: str, changes: dict[str, str]
) -> None:
    folder = write_seed(tmp_path, 0)
    write_scratch(folder, name)
    write_drives_again(folder / f"drives_{name}.csv", **changes)
    assert read_scratch(tmp_path, read_experiment(tmp_path)).drives.empty


def test_a_seed_without_errors_has_none(tmp_path: Path) -> None:
    write_run(tmp_path / "seed_0")
    (write_run(tmp_path / "seed_1") / "errors.json").unlink()
    assert read_errors(tmp_path).keys() == {0}
