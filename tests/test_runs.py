"""What runs are told is checked before anything runs, and unrolled into the loops of the pipeline."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.loops import loops as unrolled
from pipeline.runs import Comparison, read_params
from tests.command import run

ROOT = Path(__file__).parent.parent
LOOK = {"name": "One", "words": "One.", "colour": "black", "marker": "o", "driven_by": "naive"}
LONG, SHORT = {"seconds": 20}, {"seconds": 4}
ONE: dict[str, Any] = LOOK | {
    "strategy": "safedagger",
    "protocol": "long",
    "queries": [30, 10],
    "samples": [500],
    "tau": [0.1],
}
DAGGER = LOOK | {
    "strategy": "dagger",
    "protocol": "long",
    "frames": [90],
    "sample": [30],
    "samples": [500],
    "tau": [0.1],
}


def loops(**runs: dict[str, Any]) -> dict[str, Any]:
    return unrolled(Comparison.of({"runs": runs, "protocols": {"long": LONG, "short": SHORT}}))


def test_a_run_is_a_loop_that_begins_with_the_supervised_stage() -> None:
    found = loops(one=ONE)
    assert found["rollouts"] == {
        "one_1": {"iteration": 1, "primary": "0", "safety": "0"}
        | {"asks": {"queries": 30}, "protocol": LONG},
        "one_2": {"iteration": 2, "primary": "one_1", "safety": "one_1"}
        | {"asks": {"queries": 10}, "protocol": LONG},
    }
    assert found["merges"] == {"one_1": {"previous": "0"}, "one_2": {"previous": "one_1"}}
    assert found["steps"] == {
        "one_1": {"previous": "0", "data": "one_1", "samples": 500},
        "one_2": {"previous": "one_1", "data": "one_2", "samples": 500},
    }
    labels = {"tau": 0.1, "horizon": 0, "horizon-mode": "last"}
    assert found["safeties"]["one_2"] == {
        "primary": "one_2",
        "safe": "safe",
        "data": "one_2",
        "labels": labels,
        "strategies": "naive",
    }
    assert list(found["safeties"]) == list(found["evaluated"]) == ["0", "one_1", "one_2"]
    assert found["ledgers"]["one_1"] == {"driven": "rollout_one_1"}
    assert found["pictured"] == ["one_1"]


def test_each_iteration_has_its_own_numbers_where_there_are_several() -> None:
    found = loops(one=ONE | {"samples": [7, 8], "tau": [0.1, 0.2, 0.4]})
    assert [step["samples"] for step in found["steps"].values()] == [7, 8]
    assert [safety["labels"]["tau"] for safety in found["safeties"].values()] == [0.1, 0.2, 0.4]


def test_only_equal_labels_share_the_safety_policy_of_the_supervised_stage() -> None:
    found = loops(one=ONE, same=ONE | {"tau": [0.1, 0.2, 0.2]}, ahead=ONE | {"horizon": 1})
    firsts = [found["rollouts"][f"{name}_1"]["safety"] for name in ("one", "same", "ahead")]
    assert firsts == ["0", "0", "ahead_0"]
    assert found["safeties"]["ahead_0"]["primary"] == "0"


def test_a_run_may_have_better_safety_policies_than_the_papers() -> None:
    better = {"learns": "size", "calibration": 0.2, "cut": 0.7}
    found = loops(one=ONE, better=ONE | better)["safeties"]
    assert found["better_0"]["labels"] == found["0"]["labels"] | better
    assert not better.keys() & found["0"]["labels"].keys()


def test_dagger_and_supervised_learning_need_no_safety_policy_to_drive() -> None:
    supervised = LOOK | {"strategy": "supervised", "episodes": [4], "samples": [9], "tau": [0.1]}
    supervised |= {"protocol": "short"}
    found = loops(one=DAGGER, two=supervised)
    assert found["dagger"]["one_1"] == {
        "iteration": 1,
        "previous": "0",
        "beta": 0,
        "ask": 1,
        "frames": 90,
        "sample": 30,
        "protocol": LONG,
    }
    assert found["supervised"] == {"two_1": {"iteration": 1, "episodes": 4, "protocol": SHORT}}
    assert found["ledgers"]["two_1"] == {"driven": "new_two_1"}
    assert (found["rollouts"], found["pictured"]) == ({}, [])


def test_training_alone_collects_nothing_and_goes_on_with_what_there_is() -> None:
    more = LOOK | {"strategy": "training", "samples": [500, 700], "tau": [0.1], "driven_by": ""}
    found = loops(one=ONE, more=more)
    assert found["steps"]["more_2"] == {"previous": "more_1", "data": "0", "samples": 700}
    for loop in ("merges", "ledgers", "safeties", "evaluated"):
        assert not [step for step in found[loop] if step.startswith("more")], loop


def test_a_safety_policy_that_nobody_asks_is_not_trained() -> None:
    """Of a run that is not evaluated, only those that a rollout needs."""
    found = loops(one=ONE | {"driven_by": ""}, two=DAGGER | {"driven_by": ""})
    assert list(found["safeties"]) == ["0", "one_1"]
    assert found["evaluated"] == {}


AUDITED = ONE | {"queries": [30, 20, 10], "audit": 0.1, "driven_by": ""}


def test_audits_of_all_iterations_are_for_the_safety_policy() -> None:
    """Of the last rollout there is none to learn from them."""
    found = loops(one=ONE, two=AUDITED)
    assert found["rollouts"]["two_1"]["asks"] == {"queries": 30, "audit": 0.1}
    assert found["rollouts"]["two_1"]["safety"] == "0"
    assert found["audits"] == {
        "two_1": {"selected": "D_audits_two_1"},
        "two_2": {"selected": "new_audits_two_2"},
    }
    assert found["merges"]["audits_two_2"] == {"previous": "audits_two_1"}
    assert list(found["safeties-audited"]) == ["two_1", "two_2"]
    assert found["safeties-audited"]["two_2"]["safe"] == "safe"
    assert not [step for step in found["safeties"] if step.startswith("two")]


def test_what_is_set_aside_of_d_0_takes_the_place_of_d_safe() -> None:
    """So its loop begins with a primary of its own."""
    found = loops(one=ONE, two=AUDITED | {"set_aside": 0.2})
    assert found["set-aside"] == {"two_0": {"share": 0.2}}
    first = found["safeties"]["two_0"]
    assert (first["primary"], first["safe"], first["data"]) == ("two_0", "safe_two_0", "two_0")
    assert found["safeties-audited"]["two_1"]["safe"] == "safe_two_0"
    rollout = found["rollouts"]["two_1"]
    assert (rollout["primary"], rollout["safety"]) == ("two_0", "two_0")
    assert found["merges"]["two_1"] == {"previous": "two_0"}
    assert found["steps"]["two_1"]["previous"] == "two_0"
    assert found["steps"]["one_1"]["previous"] == "0"


def test_a_run_may_have_a_part_of_d_safe() -> None:
    """So its first safety policy is its own, and watches the primary of all."""
    found = loops(one=ONE, two=ONE | {"d_safe": 0.25}, three=AUDITED | {"d_safe": 0.25})
    assert found["parts-of-D_safe"] == {f"safe_{n}": {"share": 0.25} for n in ("two", "three")}
    safeties = found["safeties"] | found["safeties-audited"]
    for name in ("two", "three"):
        first = safeties[f"{name}_0"]
        assert (first["primary"], first["safe"], first["data"]) == ("0", f"safe_{name}", "0")
        assert safeties[f"{name}_1"]["safe"] == f"safe_{name}"
        rollout = found["rollouts"][f"{name}_1"]
        assert (rollout["primary"], rollout["safety"]) == ("0", f"{name}_0")
        assert found["ledgers"][f"safe_{name}"] == {"driven": f"D_safe_{name}"}
        assert found["steps"][f"{name}_1"]["previous"] == "0"
    assert safeties["0"]["safe"] == safeties["one_2"]["safe"] == "safe"
    assert found["ledgers"]["safe"] == {"driven": "D_safe"}


def test_each_primary_is_counted_on_in_the_end_and_between_where_it_is_told() -> None:
    told = {"runs": {"one": ONE}, "protocols": {"long": LONG}}
    assert unrolled(Comparison.of(told))["relied-on"] == {}
    for there, between in (({"between": "a"}, {"one_1": "a"}), ({}, {})):
        found = unrolled(Comparison.of(told | {"reliability": {"ends": "a,b"} | there}))
        scenarios = {step: told["scenarios"] for step, told in found["relied-on"].items()}
        assert scenarios == {"0": "a,b", "one_2": "a,b"} | between
    aside = {"two": AUDITED | {"set_aside": 0.2}}
    told |= {"runs": told["runs"] | aside, "reliability": {"ends": "a,b", "between": "a"}}
    assert unrolled(Comparison.of(told))["relied-on"]["two_0"] == {"scenarios": "a,b"}


def test_what_stands_beside_the_loops() -> None:
    told = {"runs": {"one": ONE | {"from_scratch": [2]}}, "thresholds": [0.000625, 0.04]}
    told |= {"protocols": {"long": LONG}}
    found = unrolled(Comparison.of(told))
    assert found["from-scratch"] == {"scratch_2": {"data": "one_2", "samples": 500}}
    beside = {n: s for n, s in found["safeties"].items() if n.startswith(("tau", "scratch"))}
    assert list(beside) == ["scratch_2", "tau_000625", "tau_04"]
    assert beside["tau_04"]["labels"]["tau"] == 0.04
    assert beside["scratch_2"]["primary"] == "scratch_2"


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
