"""What was driven, beside the experiment too, each drive once."""

import shutil
from pathlib import Path

from pipeline.report.material import read_material
from tests.evaluation.sample import drives, write_run


def test_what_was_driven_is_counted_once(tmp_path: Path) -> None:
    """Iteration 0 stands for both runs, and beside another threshold; an iteration from scratch."""
    folder = write_run(tmp_path / "seed_0")
    for file in sorted(folder.glob("*_safedagger_?.*")):
        shutil.copy(file, folder / file.name.replace("safedagger", "dagger"))
    for kind in ("drives_{}.csv", "driving_{}.json", "safety_{}.json"):
        for name in ("tau_01", "scratch_3"):
            shutil.copy(folder / kind.format("safedagger_1"), folder / kind.format(name))
    text = (folder / "safety_tau_01.json").read_text()
    (folder / "safety_tau_01.json").write_text(text.replace("0.0025", "0.01"))
    driven = read_material(tmp_path).driven
    loops = [f"{run}_{i}" for run in ("dagger", "safedagger") for i in (1, 2, 3)]
    assert set(driven.step) == {"0", *loops, "scratch_3", "tau_01"}
    assert len(driven) == len(drives(0)) * 9
