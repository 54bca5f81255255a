"""What was driven, beside the experiment too, each drive once."""

from pathlib import Path

from pipeline.report.material import read_material
from tests.evaluation.made_up import GROWING, experiment
from tests.evaluation.made_up_curves import write_seed
from tests.evaluation.written import write, write_beside


def test_what_was_driven_is_counted_once(tmp_path: Path) -> None:
    """Iteration 0 stands for both runs, and beside another threshold; an iteration from scratch."""
    folder = write(experiment({"safedagger": GROWING, "dagger": GROWING}, starts=1), tmp_path)
    write_beside(folder, "tau_01", tau=0.01)
    write_beside(folder, "scratch_3")
    driven = read_material(tmp_path).driven
    loops = [f"{run}_{i}" for run in ("dagger", "safedagger") for i in (1, 2, 3)]
    assert set(driven.step) == {"0", *loops, "scratch_3", "tau_01"}
    assert len(driven) == 12 * 9


def test_how_reliable_primaries_are_lies_beside_what_they_drove(tmp_path: Path) -> None:
    folder = write(experiment({"safedagger": GROWING}, starts=1), tmp_path)
    told = (folder / "runs.json").read_bytes()
    write_seed(folder, "0", "safedagger_3", ledgers=False)
    (folder / "runs.json").write_bytes(told)
    relied_on = read_material(tmp_path).relied_on
    assert [*relied_on.iterations("safedagger")] == [0, 3]
    assert len(relied_on.drives) == 2 * 4
    assert len(read_material(tmp_path).experiment.drives) == len(
        experiment({"safedagger": GROWING}, starts=1).drives
    )
