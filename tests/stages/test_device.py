"""`--device`, of the commands that run a network."""

from pathlib import Path

import pytest
import typer

from stages import __main__ as cli
from tests.command import run
from tests.stages.test_another_world import CONV, FIT, SAFETY, TASK, collect

TRACK = ("--tracks", "yew", "--traffic", "0", "--seconds", "1", "--action-repeat", "3")
FOUND = ("--strategy", "naive", *TRACK, "--seed", "0")
ROLLOUT = ("--queries", "9", "--frames", "20", "--iteration", "1", "--metrics", "m.json")
TYPED = {
    "train-primary": ("there", "out", *CONV, *FIT),
    "train-safety": ("there",) * 3 + ("out", *SAFETY, *FIT, "--metrics", "m.json"),
    "rollout": ("there", "there", "out", *TASK, *ROLLOUT, "--workers", "1"),
    "rollout-dagger": (
        *("there", "out", *TASK, "--beta", "0", "--frames", "9", "--iteration", "1"),
        *("--workers", "1"),
    ),
    "evaluate": (
        *("there", "there", *TRACK, "--starts", "1", "--strategies", "naive", "--seed", "0"),
        *("--drives", "d.csv", "--metrics", "m.json", "--workers", "1"),
    ),
    "errors": (
        *("there", "there", "there", "--tau", "1", "--measure", "steering"),
        *("--share", "0.5", "--figure", "f.png", "--metrics", "m.json"),
    ),
    "judge": (*("there",) * 3, "--figure", "f.png", "--metrics", "m.json"),
    "film": (
        *("there", "there", "--output", "out.gif", *FOUND, "--laps", "1"),
        *("--show-every", "1"),
    ),
    "watch": ("there", "there", *FOUND, "--save", "out.rrd"),
    "compare-policies": (*("there",) * 4, *FOUND, "--save", "out.rrd"),
}


def test_each_command_that_runs_a_network_has_the_option() -> None:
    commands = typer.main.get_command(cli.commands([])).commands  # type: ignore[attr-defined]
    having = {n for n, of in commands.items() if any(p.name == "device" for p in of.params)}
    assert having == set(TYPED)


@pytest.mark.parametrize("command", TYPED)
def test_a_device_that_there_is_not_is_refused_before_anything_is_read(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path)
    assert run(command, *TYPED[command], "--device", "cuda:99") == 2
    error = capsys.readouterr().err
    assert error.startswith("safedagger: device is 'cuda:99', expected one that this machine has: ")
    assert len(error.splitlines()) == 1
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]


def contents(folder: Path) -> dict[str, bytes]:
    """Of each file, by its path."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_the_processor_is_what_computes_by_default(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no recipe tells: what is made is the same, byte for byte."""
    monkeypatch.chdir(tmp_path)
    assert run(*collect("D_0", "D_0", 4)) == 0
    assert run(*collect("D_safe", "D_safe", 4)) == 0
    for name, device in (("a", ()), ("b", ("--device", "cpu"))):
        metrics = ("--metrics", f"{name}.json")
        made = f"primary_{name}", f"safety_{name}", f"rollout_{name}"
        policies = made[0], "D_safe", "D_0", made[1]
        assert run("train-primary", "D_0", made[0], *CONV, *FIT, *device) == 0
        assert run("train-safety", *policies, *SAFETY, *FIT, *metrics, *device) == 0
        told = (*TASK, *ROLLOUT[:-1], f"{made[2]}.json", "--workers", "1", *device)
        assert run("rollout", *made[:2], made[2], *told) == 0
    for kind in ("primary", "safety", "rollout"):
        one, other = (contents(tmp_path / f"{kind}_{name}") for name in ("a", "b"))
        assert one and one == other
