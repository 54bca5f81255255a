"""Reading every seed and run: what is missing is named."""

import json
import math
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, ROLLOUT, Experiment
from pipeline.evaluation.reading import read_experiment
from tests.evaluation.made_up import GROWING, SLOW, experiment, without
from tests.evaluation.written import drive_again, write

OURS = {"safedagger": GROWING}
BOTH = OURS | {"dagger": GROWING}


def made_up(table: dict[str, list] = BOTH, seeds: int = 1) -> Experiment:
    return experiment(table, seeds, starts=1)


def test_what_was_written_is_read(tmp_path: Path) -> None:
    """Every seed and run, each drive and each number of a ledger."""
    told = made_up(OURS | {"dagger_budget": SLOW, "supervised": GROWING}, seeds=11).of_seeds(2, 10)
    told = without(told, seed=2, run=["dagger_budget", "supervised"])
    write(told, tmp_path)
    found = read_experiment(tmp_path)
    assert found.seeds == [2, 10]
    assert found.runs == ["safedagger", "dagger_budget", "supervised"]
    assert found.iterations("dagger_budget") == [0, 1, 2, 3]
    assert found.iterations("dagger") == []
    assert found.seeds_of("safedagger", 1) == [2, 10]
    assert found.seeds_of("supervised", 1) == [10]
    assert set(found.drives.pop("task.name")) == {"driving"}
    for read, expected in ((found.drives, told.drives), (found.ledgers, told.ledgers)):
        expected = expected.reset_index(drop=True)
        pd.testing.assert_frame_equal(read, expected, check_like=True, check_dtype=False)
    judged = among(found.quality, seed=10, run="supervised", iteration=2)
    assert judged[["judged_on", "auroc", "tau"]].values.tolist() == [[HELD_OUT, 0.86, 0.0025]]
    assert found.conditions == ["no_traffic", "traffic"]


def test_rollouts_belong_to_the_policies_that_drove_them(tmp_path: Path) -> None:
    """Those of other strategies than SafeDAgger's know no safety policy."""
    write(made_up(BOTH | {"safedagger_last": GROWING}), tmp_path)
    found = among(read_experiment(tmp_path).quality, judged_on=ROLLOUT)
    assert set(found.run) == {"safedagger", "safedagger_last"}
    for _, rows in found.groupby("run"):
        assert rows.iteration.tolist() == [0, 1, 2]
        assert rows.recall.tolist() == pytest.approx([0.48, 0.46, 0.44])


def test_iteration_0_is_shared_unless_a_run_has_its_own(tmp_path: Path) -> None:
    folder = write(made_up(OURS | {"safedagger_last": GROWING}), tmp_path)
    for kind in ("safety_{}.json", "driving_{}.json", "drives_{}.csv"):
        shutil.copy(folder / kind.format("0"), folder / kind.format("safedagger_last_0"))
    text = (folder / "safety_0.json").read_text()
    (folder / "safety_safedagger_last_0.json").write_text(text.replace("0.9", "0.7"))
    found = read_experiment(tmp_path)
    first = among(found.quality, iteration=0, judged_on=HELD_OUT).set_index("run")
    assert first.auroc.to_dict() == {"safedagger": 0.9, "safedagger_last": 0.7}
    assert among(found.ledgers, iteration=0, step="safedagger_last_0").queries.tolist() == [3000]


def test_what_is_no_run_or_seed_is_left_alone(tmp_path: Path) -> None:
    folder = write(made_up(OURS), tmp_path)
    for file in sorted(folder.glob("*_safedagger_?.*")):
        for name in ("tau", "scratch"):
            shutil.copy(file, folder / file.name.replace("safedagger", name))
    for other in (tmp_path / "seed_old", tmp_path):
        shutil.copytree(folder, other, dirs_exist_ok=True)
    found = read_experiment(tmp_path)
    assert (found.seeds, found.runs) == ([0], ["safedagger"])


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
    (write(made_up(), tmp_path) / name).unlink()
    with pytest.raises(FileNotFoundError, match=rf"seed_0/{name}: no such file, expected"):
        read_experiment(tmp_path)


def test_drives_in_a_condition_of_which_nothing_is_known_are_refused(tmp_path: Path) -> None:
    file = write(made_up(OURS), tmp_path) / "driving_safedagger_1.json"
    file.write_text(file.read_text().replace('"traffic"', '"rain"'))
    with pytest.raises(ValueError, match=r"_1.json: no row of condition 'traffic', expected one"):
        read_experiment(tmp_path)


def test_without_a_number_of_laps_there_is_no_end_to_them(tmp_path: Path) -> None:
    for file in write(made_up(OURS), tmp_path).glob("driving_*.json"):
        file.write_text(file.read_text().replace('"laps": 3.0', '"laps": null'))
    assert read_experiment(tmp_path).most(METRICS["laps"]) == math.inf


@pytest.mark.parametrize("folders", [[], ["seed_0"], ["seed_0", "seed_1"]])
def test_no_results_are_refused(tmp_path: Path, folders: list[str]) -> None:
    for folder in folders:
        (tmp_path / folder).mkdir()
    with pytest.raises(ValueError, match=r"no seed_<n>/drives_<run>_<i>.csv, expected some"):
        read_experiment(tmp_path)


def test_drives_of_a_run_that_nobody_knows_are_refused(tmp_path: Path) -> None:
    folder = write(made_up(OURS), tmp_path)
    shutil.copy(folder / "drives_safedagger_1.csv", folder / "drives_dager_1.csv")
    with pytest.raises(ValueError, match=r"seed_0: drives of a run 'dager', expected one of safed"):
        read_experiment(tmp_path)


def tell(folder: Path, runs: Iterable[str] | None = None, **changes: Any) -> None:
    """Other runs, or another SafeDAgger."""
    told = json.loads((folder / "runs.json").read_text())
    told["runs"]["safedagger"] |= changes
    told["runs"] = {name: told["runs"][name] for name in runs or told["runs"]}
    (folder / "runs.json").write_text(json.dumps(told))


def seeds_and_runs(found: Experiment) -> set[tuple[int, str]]:
    """Of all tables, which have the same."""
    (there,) = {
        frozenset(zip(rows.seed, rows.run, strict=True)) - {(0, D_SAFE), (1, D_SAFE)}
        for rows in (found.drives, found.ledgers, found.quality)
    }
    return set(there)


def test_a_run_need_be_told_on_one_seed_only(tmp_path: Path) -> None:
    """A seed that was run again by default, on one on which all had been compared."""
    write(without(made_up(seeds=2), seed=1, run="dagger"), tmp_path)
    tell(tmp_path / "seed_0", runs=["safedagger"], from_scratch=[], driven_by="naive")
    found = read_experiment(tmp_path)
    assert (found.runs, found.left_out) == (["safedagger", "dagger"], ())


def test_what_was_told_something_else_is_left_out(tmp_path: Path) -> None:
    tell(write(made_up(seeds=2), tmp_path), samples=[7])
    found = read_experiment(tmp_path)
    assert seeds_and_runs(found) == {(0, "safedagger"), (0, "dagger"), (1, "dagger")}
    assert found.left_out == ("SafeDAgger, seed 1: told something else than elsewhere.",)


def test_what_began_with_another_primary_is_left_out(tmp_path: Path) -> None:
    """SafeDAgger was run again on another processor: its first primary is another there."""
    write(made_up(seeds=2), tmp_path)
    folder = tmp_path / "seed_0"
    for file in (folder / "drives_0.csv", *folder.glob("drives_safedagger_*.csv")):
        drive_again(file, begun_with="f" * 64)
    found = read_experiment(tmp_path)
    assert seeds_and_runs(found) == {(0, "safedagger"), (1, "safedagger"), (1, "dagger")}
    assert found.left_out == ("DAgger, seed 0: began with another primary.",)
