"""The label curves are read as far as they are there; intervals on a seed are exact."""

import math
from pathlib import Path

import pytest

from pipeline.evaluation.curves import families, success, yardstick
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.reading import read_crowd, read_reliability
from pipeline.evaluation.statistics import exact
from pipeline.evaluation.writing import write_metrics
from tests.evaluation.made_up_curves import SPECS, counted, curves, write_seed


def test_what_was_driven_and_asked_is_read_of_every_seed(tmp_path: Path) -> None:
    of_loop = [f"{run}_{i}" for run in ("safedagger500", "training") for i in (1, 2, 3)]
    for seed in (0, 3):
        write_seed(tmp_path / f"seed_{seed}", "0", *of_loop)
    found = read_reliability(tmp_path)
    assert (found.seeds, found.runs) == ([0, 3], ["safedagger500", "training"])
    assert found.iterations("training") == [0, 1, 2, 3]
    assert len(found.among(run="training", iteration=3, seed=3)) == 4
    spent = among(found.spent, seed=3, iteration=3).set_index("run")
    assert spent.queries.to_dict() == {"safedagger500": 300, "training": 0}
    assert spent.labels.to_dict() == {"safedagger500": 500, "training": 100}
    assert spent.calls.to_dict() == {"safedagger500": 30, "training": 0}


def test_of_a_seed_that_is_partly_done_there_is_what_is_there(tmp_path: Path) -> None:
    """Beside one whose ledgers are all but one there; here none was counted yet."""
    folder = write_seed(tmp_path / "seed_0", "0", *(f"dagger4000_{i}" for i in (1, 2, 3)))
    (folder / "ledger_D_dagger4000_2.json").unlink()
    write_seed(tmp_path / "seed_1", "0", "dagger4000_1", "dagger500_3", ledgers=False)
    found = read_reliability(tmp_path)
    assert found.seeds_of("dagger4000", 1) == [0, 1]
    assert found.seeds_of("dagger4000", 3) == [0]
    assert found.iterations("dagger500") == [0, 3]
    asked = among(found.spent, run="dagger4000").set_index(["seed", "iteration"])
    assert asked.queries[0, 1] == 100
    for unknown in ((1, 1), (0, 2), (0, 3)):
        assert asked.loc[unknown, ["queries", "labels"]].isna().all()


def test_a_run_that_sets_something_aside_begins_for_itself(tmp_path: Path) -> None:
    """With a primary of its own; what D_0 cost is the same, and D_safe is not needed."""
    folder = write_seed(tmp_path / "seed_0", "0", "dagger500_1", "aside1000_0", "aside1000_1")
    for step in (0, 1):
        file = folder / f"reliability_aside1000_{step}.csv"
        file.write_text(file.read_text().replace("0" * 64, "a" * 64))
    found = read_reliability(tmp_path)
    assert found.runs == ["dagger500", "aside1000"] and not found.left_out
    assert set(found.among(run="aside1000", iteration=0).primary) == {"a" * 64}
    spent = among(found.spent, iteration=1).set_index("run")
    assert spent.labels.to_dict() == {"aside1000": 200, "dagger500": 200}


def test_what_was_driven_in_a_crowd_is_read_apart(tmp_path: Path) -> None:
    write_seed(tmp_path / "seed_0", "0", "training_3")
    write_seed(tmp_path / "seed_0", "0", "dagger500_3", kind="crowd")
    crowd, relied_on = read_crowd(tmp_path), read_reliability(tmp_path)
    assert (crowd.runs, relied_on.runs) == (["dagger500"], ["training"])
    assert crowd.iterations("dagger500") == [0, 3]
    assert read_crowd(tmp_path / "seed_0").runs == []


def test_of_a_run_with_a_part_of_d_safe_that_part_is_counted(tmp_path: Path) -> None:
    """And not what the others had, but on a seed that has not counted it yet."""
    for seed, parts in enumerate((["safe_quarter2000"], [])):
        folder = write_seed(tmp_path / f"seed_{seed}", "0", "seldom2000_1", "quarter2000_1")
        for part in ("safe", *parts):
            asked = counted(560 if part == "safe" else 140)
            write_metrics(folder / f"ledger_D_{part}.json", {"rows": [asked]})
    spent = among(read_reliability(tmp_path).spent, iteration=1).set_index(["seed", "run"]).labels
    assert spent[0].to_dict() == {"seldom2000": 760, "quarter2000": 340}
    assert spent[1, "seldom2000"] == 760 and math.isnan(spent[1, "quarter2000"])


def test_of_nothing_there_is_nothing(tmp_path: Path) -> None:
    assert read_reliability(tmp_path).runs == []
    write_seed(tmp_path / "seed_0")
    assert yardstick(read_reliability(tmp_path)) is None


def test_a_run_that_was_told_something_else_is_left_out_and_named(tmp_path: Path) -> None:
    for seed in (0, 1):
        folder = write_seed(tmp_path / f"seed_{seed}", "0", "dagger500_1")
    told = (folder / "runs.json").read_text()
    (folder / "runs.json").write_text(told.replace('"frames":[214,', '"frames":[215,'))
    found = read_reliability(tmp_path)
    assert found.seeds_of("dagger500", 1) == [0]
    assert found.left_out == ("DAgger, 500 labels, seed 1: told something else than elsewhere.",)


def test_runs_of_one_way_to_collect_go_from_few_labels_to_many() -> None:
    assert families(curves(dict.fromkeys(SPECS, 0.9))) == {
        "SafeDAgger": ["safedagger500", "safedagger1000", "safedagger2000"],
        "DAgger": ["dagger500", "dagger1000", "dagger2000", "dagger4000"],
        "DAgger that asks seldom": ["dagger_seldom2000"],
        "supervised": ["supervised500", "supervised1000", "supervised2000"],
        "more training": ["training"],
        "SafeDAgger, from anywhere": ["safedagger1000_anywhere"],
        "DAgger, from anywhere": ["dagger1000_anywhere"],
        "SafeDAgger that learns how far": ["sized1000", "sized2000"],
        "SafeDAgger that asks seldom": ["seldom2000"],
        "SafeDAgger that asks seldom with a quarter of D_safe": ["quarter1000", "quarter2000"],
        "SafeDAgger with audits": ["audited1000", "audited2000"],
        "SafeDAgger with audits for D_safe": ["aside1000", "aside2000"],
    }
    alone = curves({"safedagger1000_anywhere": 0.9})
    assert [*families(alone)] == ["SafeDAgger, from anywhere"]
    assert yardstick(alone) == "dagger4000"  # whether or not it has ended


def test_the_exact_interval_is_that_of_the_tables() -> None:
    """Clopper and Pearson's; where all succeed, its low end is the 40th root of 0.025."""
    whole = exact(40, 40)
    assert (whole.value, whole.high) == (1.0, 1.0)
    assert whole.low == pytest.approx(0.025 ** (1 / 40))
    most = exact(38, 40)
    assert (most.low, most.high) == pytest.approx((0.8308, 0.9939), abs=1e-4)


def test_success_is_exact_on_one_seed_and_resampled_over_several() -> None:
    def of(made_up: Experiment) -> tuple[float, float]:
        found = success(made_up, "dagger500", 3, "traffic")
        assert found.value == 0.95
        return found.low, found.high

    assert of(curves({"dagger500": 0.95})) == (exact(38, 40).low, exact(38, 40).high)
    over_all = curves({"dagger500": 0.95}, seeds=3)
    assert of(over_all.of_seeds(1)) == of(curves({"dagger500": 0.95}))
    assert of(over_all)[0] not in (exact(38, 40).low, exact(114, 120).low)  # seeds are no drives


def test_more_drives_narrow_the_interval() -> None:
    for seeds in (1, 3):
        widths = []
        for tracks in (20, 40, 80, 160):
            found = success(curves({"dagger500": 0.9}, seeds, tracks), "dagger500", 3, "traffic")
            widths.append(found.high - found.low)
        assert widths == sorted(widths, reverse=True)
