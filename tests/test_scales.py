"""The parameter files: one pipeline, run small, as a comparison, and at the paper's scale."""

from pathlib import Path
from typing import Any

import pytest
import typer
import yaml
from dvc.utils.hydra import apply_overrides

from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.task import Driving
from pipeline.loops import loops, render
from pipeline.runs import Comparison, read_params
from stages import __main__ as cli
from stages import parameters

ROOT = Path(__file__).parent.parent
FILES = ["params.yaml", "scales/experiment.yaml", "scales/paper.yaml"]


def test_an_experiment_changes_only_its_line(tmp_path: Path) -> None:
    """`dvc exp run -S seed=1` writes the file anew: all else has to be as DVC would write it."""
    before = (ROOT / "params.yaml").read_text()
    (tmp_path / "params.yaml").write_text(before)
    apply_overrides(tmp_path / "params.yaml", ["seed=1"])
    after = (tmp_path / "params.yaml").read_text()
    assert after == before.replace("\nseed: 0\n", "\nseed: 1\n") != before


def read(name: str) -> dict[str, Any]:
    """What a file says, and the loops that its runs come to."""
    params = read_params(ROOT / name)
    return params | loops(Comparison.of(params))


@pytest.mark.parametrize("name", FILES)
def test_every_scale_has_the_same_options(name: str) -> None:
    found, expected = read_params(ROOT / name), read_params(ROOT / "params.yaml")
    assert found.keys() == expected.keys()
    for group, options in expected.items():
        if isinstance(options, dict) and group != "runs":
            assert found[group].keys() == options.keys(), group


@pytest.mark.parametrize("name", [*FILES, "scales/curves.yaml"])
def test_every_name_in_a_scale_is_known(name: str) -> None:
    assert parameters.read(ROOT / name, ROOT / "dvc.yaml").runs


@pytest.mark.parametrize("name", ["dvc.yaml", "examples/metaworld/dvc.yaml"])
def test_how_many_processes_drive_is_no_part_of_a_result(name: str) -> None:
    """Else another machine would run everything again, for equal bytes."""
    pipeline = (ROOT / name).read_text()
    assert "--workers" not in pipeline and "--threads ${threads}" in pipeline


def test_what_is_not_typed_is_as_the_default_scale_has_it() -> None:
    params = read_params(ROOT / "params.yaml")
    shared = {"seed": params["seed"]}
    drive = params["drive"] | shared | {"workers": None}
    drive |= {"tracks": params["tracks"]["training"]}
    training = shared | {"threads": params["threads"]}
    run = params["runs"]["safedagger"]
    protocol = params["protocols"][run["protocol"]]
    told = {
        "collect": drive | {"episodes": params["d-0"]["episodes"]},
        "train-primary": params["primary-0"] | params["train-primary"] | training,
        "train-safety": params["train-safety"] | {"tau": run["tau"][0], "measure": ""} | training,
        "rollout": drive
        | {"frames": params["rollout"]["frames"]}
        | {name: protocol[name] for name in ("begins", "seconds")},
    }
    told["rollout"] |= {"queries": run["queries"][0]}
    commands = typer.main.get_command(cli.commands([])).commands
    for command, expected in told.items():
        defaults = {each.opts[0].lstrip("-"): each.default for each in commands[command].params}
        assert {name: defaults[name] for name in expected} == expected, command
        typed = [each.opts[0] for each in commands[command].params if each.required]
        assert not [name for name in typed if name.startswith("-")], "paths are all that must be"
    assert PrimaryNetwork.measure == params["train-safety"]["measure"]


def test_the_loops_are_those_of_the_runs() -> None:
    """Else: `safedagger plan`."""
    comparison = Comparison.of(read_params(ROOT / "params.yaml"))
    assert (ROOT / "loops.yaml").read_text() == render(comparison)
    assert yaml.safe_load(render(comparison)) == loops(comparison)


@pytest.mark.parametrize("name", FILES)
def test_every_step_has_what_it_needs(name: str) -> None:
    """Its predecessor, one source of new data, a safety policy that is evaluated, and a ledger."""
    scale = read(name)
    steps, primaries = scale["steps"], {"0", *scale["steps"]}
    sources = [*scale["rollouts"], *scale["dagger"], *scale["supervised"]]
    assert sorted(sources) == sorted(steps)
    assert {step["previous"] for step in steps.values()} <= primaries
    assert set(scale["relied-on"]) == primaries
    assert primaries | set(scale["from-scratch"]) <= set(scale["evaluated"])
    data = {name: name for name in primaries}
    data |= {name: scratch["data"] for name, scratch in scale["from-scratch"].items()}
    for safety in scale["safeties"].values():
        assert safety["data"] == data[safety["primary"]]
        assert safety["data"] in primaries
    assert set(scale["ledgers"]) == primaries | {"safe"}
    for step, rollout in scale["rollouts"].items():
        assert rollout["primary"] == steps[step]["previous"]
        assert scale["safeties"][rollout["safety"]]["primary"] == rollout["primary"]
    for step, rollout in scale["dagger"].items():
        assert rollout["previous"] == steps[step]["previous"]


@pytest.mark.parametrize("name", FILES)
def test_iterations_follow_each_other(name: str) -> None:
    """Step <run>_<i> is iteration i, after <run>_<i - 1> or the supervised stage."""
    scale = read(name)
    for loop in ("rollouts", "dagger", "supervised"):
        for step, settings in scale[loop].items():
            run, number = step.rsplit("_", 1)
            assert settings["iteration"] == int(number)
            before = f"{run}_{int(number) - 1}" if number != "1" else "0"
            assert scale["steps"][step]["previous"] == before


def test_the_comparison_is_the_default_run_with_more_strategies_beside_it() -> None:
    """So both make the same SafeDAgger; the comparison asks for more of its evaluation."""
    default, comparison = (read_params(ROOT / name) for name in FILES[:2])
    for group in default.keys() - {"runs", "thresholds", "reliability"}:
        assert default[group] == comparison[group], group
    for name, run in default["runs"].items():
        more = {"from_scratch": [3], "driven_by": "naive,safe,optimal"}
        assert run | more == comparison["runs"][name]


def test_all_strategies_train_on_as_many_new_frames() -> None:
    """Sec. 4.2: 30k, 30k and 10k, whoever chose them; at the default scale a tenth."""
    for name, unit in (("scales/experiment.yaml", 1000), ("scales/paper.yaml", 10_000)):
        scale = read(name)
        budgets = dict(zip((1, 2, 3), (3 * unit, 3 * unit, unit), strict=True))
        for rollout in scale["rollouts"].values():
            assert rollout["asks"] == {"queries": budgets[rollout["iteration"]]}
        for rollout in scale["dagger"].values():
            assert rollout["sample"] == budgets[rollout["iteration"]]
        seconds = scale["protocols"][scale["runs"]["supervised"]["protocol"]]["seconds"]
        frames = seconds * 30 / scale["drive"]["action-repeat"]
        for drives in scale["supervised"].values():
            wanted = budgets[drives["iteration"]]
            assert wanted <= drives["episodes"] * frames < wanted + frames


@pytest.mark.parametrize("name", FILES)
def test_no_track_that_is_measured_on_is_trained_on_or_chosen_by(name: str) -> None:
    params = read_params(ROOT / name)
    tracks = [set(Driving(tracks=each, traffic=0).scenarios) for each in params["tracks"].values()]
    tracks.append(set(Driving(tracks=params["reliability"]["ends"], traffic=0).scenarios))
    assert sum(map(len, tracks)) == len(set.union(*tracks))
    for more in params["reliability"].keys() - {"ends"}:
        told = params["reliability"][more]
        assert set(Driving(tracks=told, traffic=0).scenarios) <= tracks[-1], more
