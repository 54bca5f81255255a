"""What stands beside an experiment: other thresholds, primaries from scratch, errors."""

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.drives import among
from pipeline.evaluation.reading import (
    SCRATCH,
    WARM,
    read_errors,
    read_experiment,
    read_scratch,
    read_thresholds,
)
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import GROWING, SLOW, drives, experiment
from tests.evaluation.written import drive_again, write, write_beside, write_run


def test_thresholds_of_all_seeds_are_read_by_tau(tmp_path: Path) -> None:
    """A seed without other thresholds is left out."""
    write_run(tmp_path, seeds=4)
    write_beside(tmp_path / "seed_3", "tau_04", tau=0.04)
    write_beside(tmp_path / "seed_3", "tau_000625", tau=0.000625, iteration=2)
    write_beside(tmp_path / "seed_2", "tau_04", tau=0.04)
    found = read_thresholds(tmp_path)
    seeds = {tau: found.seeds_of(tau, 0) for tau in set(found.drives.run)}
    assert seeds == {"0.000625": [3], "0.0025": [2, 3], "0.04": [2, 3]}
    assert among(found.quality, run="0.000625").auroc.tolist() == [0.86]
    takeovers = [
        estimate(found, "takeover", Cell(tau, (0,), Strategy.SAFE, ("traffic",)))
        for tau in ("0.0025", "0.04", "0.000625")
    ]
    assert [each and each.value for each in takeovers] == [0.2, 0.15, 0.1]


def test_a_threshold_of_another_primary_is_not_compared(tmp_path: Path) -> None:
    folder = write_run(tmp_path)
    write_beside(folder, "tau_01", tau=0.01)
    drive_again(folder / "drives_tau_01.csv", primary="f" * 64)
    assert set(read_thresholds(tmp_path).drives.run) == {"0.0025"}


def test_a_tau_that_a_seed_has_twice_is_refused(tmp_path: Path) -> None:
    folder = write_run(tmp_path)
    for name in ("tau_01", "tau_010"):
        write_beside(folder, name, tau=0.01)
    problem = r"drives_tau_010.csv: tau is 0.01 again, expected another"
    with pytest.raises(ValueError, match=problem):
        read_thresholds(tmp_path)


def test_the_warm_counterpart_stands_beside_the_primary_from_scratch(tmp_path: Path) -> None:
    write_beside(write_run(tmp_path), "scratch_3")
    found = read_scratch(tmp_path, read_experiment(tmp_path))
    assert found.drives.groupby("run").step.unique().map(list).to_dict() == {
        WARM: ["safedagger_3"],
        SCRATCH: ["scratch_3"],
    }
    for run, iteration in ((SCRATCH, 1), (WARM, 3)):
        expected = drives(GROWING[iteration], starts=2)
        assert found.among(run=run).laps.tolist() == expected.laps.tolist()


def test_the_warm_one_is_of_the_run_that_was_trained_from_scratch_too(tmp_path: Path) -> None:
    write_beside(write(experiment({"safedagger": GROWING, "dagger": SLOW}), tmp_path), "scratch_3")
    found = read_experiment(tmp_path)
    iterations = {"safedagger": [], "dagger": [3]}
    specs = {
        run: spec.model_copy(update={"from_scratch": iterations.get(run, [])})
        for run, spec in found.specs.items()
    }
    pairs = read_scratch(tmp_path, replace(found, specs=specs))
    assert set(pairs.among(run=WARM).step) == {"dagger_3"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [("scratch_7", {}), ("scratch_new", {}), ("scratch_3", {"begun_with": "f" * 64})],
    ids=["no counterpart", "no iteration", "another first primary"],
)
def test_what_cannot_be_compared_is_left_alone(
    tmp_path: Path, name: str, changes: dict[str, str]
) -> None:
    folder = write_run(tmp_path)
    write_beside(folder, name)
    drive_again(folder / f"drives_{name}.csv", **changes)
    assert read_scratch(tmp_path, read_experiment(tmp_path)).drives.empty


def test_a_seed_without_errors_has_none(tmp_path: Path) -> None:
    (write_run(tmp_path, seeds=2) / "errors.json").unlink()
    assert read_errors(tmp_path).keys() == {0}
