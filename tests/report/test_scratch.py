"""A primary from scratch beside the warm one: pairs of the same starts, and which gets further."""

import shutil
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from pipeline.evaluation.drives import write_drives
from pipeline.evaluation.experiment import Experiment, read_experiment
from pipeline.report.scratch import SCRATCH, WARM, read_scratch, warm_or_scratch
from tests.evaluation.made_up import Level, experiment, of_steps, only
from tests.evaluation.sample import drives, write_run


def pairs(warm: Level, scratch: Level, starts: int = 4) -> Experiment:
    """Iteration 3 both ways."""
    made_up = experiment({"safedagger": [warm] * 4, "dagger": [scratch] * 4}, starts=starts)
    one = replace(made_up.steps[0, "safedagger", 3], run=WARM)
    other = replace(made_up.steps[0, "dagger", 3], run=SCRATCH)
    return of_steps({(0, WARM, 3): one, (0, SCRATCH, 3): other})


def test_the_warm_counterpart_stands_beside_it(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "seed_4")
    shutil.copy(folder / "drives_safedagger_1.csv", folder / "drives_scratch_3.csv")
    whole = read_experiment(tmp_path)
    found = read_scratch(tmp_path, whole)
    assert found.steps.keys() == {(4, WARM, 3), (4, SCRATCH, 3)}
    assert found.steps[4, WARM, 3].name == "safedagger_3"
    assert found.steps[4, WARM, 3].drives is whole.steps[4, "safedagger", 3].drives
    pd.testing.assert_frame_equal(found.steps[4, SCRATCH, 3].drives, drives(1))
    assert found.steps[4, SCRATCH, 3].name == "scratch_3"


def test_what_has_no_counterpart_is_left_alone(tmp_path: Path) -> None:
    """Another iteration, a folder that is no seed, another name."""
    folder = write_run(tmp_path / "seed_0")
    shutil.copy(folder / "drives_0.csv", folder / "drives_scratch_7.csv")
    shutil.copy(folder / "drives_0.csv", folder / "drives_scratch_new.csv")
    shutil.copytree(folder, tmp_path / "seed_old")
    assert read_scratch(tmp_path, read_experiment(tmp_path)).steps == {}


def test_what_began_with_another_primary_is_not_compared(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "seed_0")
    write_drives(folder / "drives_scratch_3.csv", drives(1).assign(begun_with="f" * 64))
    assert read_scratch(tmp_path, read_experiment(tmp_path)).steps == {}


@pytest.mark.parametrize(
    ("warm", "scratch", "starts", "verdict"),
    [
        (2.5, 2.0, 4, "the primary with the warm start gets further"),
        (2.0, 2.5, 4, "the primary trained from scratch gets further"),
        (2.0, 2.0, 4, "which primary gets further is undecided"),
        (2.0, 2.5, 1, "which primary gets further is undecided"),  # three pairs prove nothing
    ],
)
def test_one_sentence_says_which_gets_further(
    warm: float, scratch: float, starts: int, verdict: str
) -> None:
    found = pairs(Level(laps=(warm, warm)), Level(laps=(scratch, scratch)), starts)
    sentence = warm_or_scratch(found).split("\n\n")[0]
    gap = f"{scratch - warm:+.2f}"
    assert sentence == (
        f"On D_3, {verdict}: over both conditions, from scratch minus warm is "
        f"{gap} [{gap}, {gap}] laps, in {3 * starts} pairs of drives."
    )


def test_laps_and_error_stand_side_by_side_with_their_difference() -> None:
    found = pairs(
        Level(laps=(3.0, 2.0), error=(0.01, 0.02)), Level(laps=(2.5, 2.2), error=(0.02, 0.02))
    )
    *_, first, second, third, fourth = warm_or_scratch(found).splitlines()
    assert first == (
        "| D_3 | laps, without traffic | 3.00 [3.00, 3.00] | 2.50 [2.50, 2.50] | "
        "-0.50 [-0.50, -0.50] |"
    )
    assert second.startswith("| D_3 | laps, with traffic | 2.00 [2.00, 2.00] | 2.20")
    assert third.endswith("| 0.01 [0.01, 0.01] | 0.02 [0.02, 0.02] | +0.01 [+0.01, +0.01] |")
    assert fourth.startswith("| D_3 | steering MSE, with traffic | 0.02 [0.02, 0.02] | 0.02")


def test_what_was_not_driven_is_not_compared() -> None:
    found = pairs(Level(), Level())
    step = found.steps[0, SCRATCH, 3]
    quiet = only(step, condition="no_traffic")
    text = warm_or_scratch(of_steps({**found.steps, (0, SCRATCH, 3): quiet}))
    assert text.startswith("On D_3, no start was given to both.")
    assert "| D_3 | laps, with traffic | 1.50 [1.50, 1.50] | - | - |" in text
