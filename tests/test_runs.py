"""What runs are told is checked before anything runs."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.runs import read_params
from tests.command import run
from tests.loops import DAGGER, ONE, loops

ROOT = Path(__file__).parent.parent


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"querys": [1]}, "runs.one.querys: Extra inputs are not permitted"),
        ({"strategy": "active"}, "runs.one.strategy: Input should be 'supervised', 'dagger', '"),
        ({"queries": [0]}, "runs.one.queries.0: Input should be greater than or equal to 1"),
        ({"queries": []}, "runs.one: queries of a safedagger run: 0 given, one for each iteration"),
        ({"frames": [9]}, "runs.one: frames of a safedagger run: 1 given, none"),
        ({"samples": [1, 2, 3]}, "runs.one: samples: 3 given, expected 1 or 2"),
        ({"tau": [0.1, 0.2]}, "runs.one: tau: 2 given, expected 1 or 3"),
        ({"from_scratch": [3]}, "runs.one: from_scratch: 3, expected 2 at most"),
        ({"variant_of": "two"}, "runs: one: there is no run 'two' to be a variant of"),
        ({"protocol": "slow"}, "runs: one: protocol 'slow', expected long, short"),
        (
            {"set_aside": 0.2},
            "runs: one: set_aside in the first run, expected all of D_0 in its place",
        ),
        ({"d_safe": 0.2}, "runs: one: d_safe in the first run, expected all of D_safe there"),
        ({"ask": 0.1}, "runs.one: ask of a safedagger run, expected of dagger alone"),
        (
            {**DAGGER, "queries": [], "ask": 0},
            "runs.one.ask: Input should be greater than or equal",
        ),
        (
            {**DAGGER, "queries": [], "sample": [91]},
            "runs.one: sample: 91 of iteration 1, expected at most its 90 frames",
        ),
        ({"d_safe": 0}, "runs.one.d_safe: Input should be greater than 0"),
        (
            {"set_aside": 0.2, "d_safe": 0.2},
            "runs.one: set_aside is in the place of D_safe, expected no d_safe beside it",
        ),
        (
            {**DAGGER, "queries": [], "d_safe": 0.5},
            "runs.one: d_safe of a dagger run, expected of safedagger alone",
        ),
        (
            {**DAGGER, "queries": [], "audit": 0.1},
            "runs.one: audit of a dagger run, expected of safeda",
        ),
    ],
)
def test_what_does_not_fit_is_one_line(changes: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError) as error:
        loops(one=ONE | changes)
    assert str(error.value).startswith(problem)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("runs", [{}, {"One": ONE}, {"one_1": ONE}, {"tau": ONE}])
def test_names_are_words(runs: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"^runs"):
        loops(**runs)


@pytest.mark.parametrize(
    ("text", "problem"),
    [(None, "no such file"), ("runs: [", "expected YAML"), ("- 1", "expected names with values")],
)
def test_what_is_no_file_of_parameters_is_named(
    text: str | None, problem: str, tmp_path: Path, refused: Callable[..., str]
) -> None:
    if text is not None:
        (tmp_path / "params.yaml").write_text(text)
    line = refused("plan --params params.yaml --loops loops.yaml")
    assert line.startswith("params.yaml: ") and problem in line


def test_a_line_more_is_a_run_more(tmp_path: Path) -> None:
    params, out = tmp_path / "params.yaml", tmp_path / "loops.yaml"
    text = "protocols: {{long: {{}}}}\nruns:\n  one: {}\n"
    line = (
        "{strategy: dagger, frames: [9], sample: [9], samples: [9], tau: [0], driven_by: naive, "
        "name: a, words: a., colour: black, marker: o, protocol: long}"
    )
    params.write_text(text.format(line))
    plan = f"plan --params {params} --loops {out}"
    assert run(plan) == 0
    before = read_params(out)
    params.write_text(text.format(line) + f"  two: {line}\n")
    out.unlink()
    assert run(plan) == 0
    assert set(read_params(out)["dagger"]) - set(before["dagger"]) == {"two_1"}


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (
            ("  channels:", "  chanels:"),
            "train-primary: chanels is no option of `safedagger train-primary`, expected one such "
            "as channels",
        ),
        (
            ("  offset-spread: 0.9", "  offset_spread: 0.9"),
            "d-safe: offset_spread is no option of `safedagger collect`, expected one such as "
            "offset-spread",
        ),
        (
            ("    begins:", "    begin:"),
            "protocols: anywhere: begin is no option of `safedagger rollout`, expected one such as "
            "begins",
        ),
        (
            ("train-primary:", "train-primery:"),
            "train-primery: dvc.yaml has no ${train-primery}, expected one such as train-primary",
        ),
        (
            ("\nthreads:", "\nthread:"),
            "thread: dvc.yaml has no ${thread}, expected one such as threads",
        ),
        (
            ("naive,safe\n", "naive,saef\n"),
            "runs.safedagger.driven_by: 'saef', expected one of naive, safe, optimal",
        ),
        (("\nseed:", "\nrollouts: 3\nseed:"), "rollouts: dvc.yaml has no ${rollouts}, expected"),
        (
            ("  channels:", "  policy: conv\n  channels:"),
            "train-primary: mirror is no option of `safedagger train-primary`, expected one such as",
        ),
    ],
)
def test_a_mistyped_parameter_stops_it_before_anything_runs(
    change: tuple[str, str], problem: str, tmp_path: Path, refused: Callable[..., str]
) -> None:
    (tmp_path / "params.yaml").write_text((ROOT / "params.yaml").read_text().replace(*change, 1))
    (tmp_path / "dvc.yaml").symlink_to(ROOT / "dvc.yaml")
    for command in ("plan --loops out", f"runs --loops {ROOT}/loops.yaml --metrics out"):
        line = refused(f"{command} --params params.yaml")
        assert line.startswith(f"params.yaml: {problem}")


def test_loops_that_are_not_those_of_the_runs_stop_it(
    tmp_path: Path, refused: Callable[..., str]
) -> None:
    loops = (ROOT / "loops.yaml").read_text()
    (tmp_path / "loops.yaml").write_text(loops.replace('"queries": 3000', '"queries": 3001'))
    files = f"--params {ROOT}/params.yaml --pipeline {ROOT}/dvc.yaml --loops loops.yaml"
    assert refused(f"runs {files} --metrics runs.json").startswith("loops.yaml: not what ")
