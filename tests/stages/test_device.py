"""`--device`, of the commands that run a network."""

from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from stages import __main__ as cli
from tests.command import run
from tests.files import tree
from tests.stages.test_another_world import CONV, DRIVEN, SAFETY, collect

TRACK = "--tracks yew --traffic 0 --seconds 1 --action-repeat 3 --seed 0"
FOUND = f"{TRACK} --strategy naive"
ROLLOUT = f"{DRIVEN} --queries 9 --frames 20 --iteration 1"
TYPED = {
    "train-primary": f"there out {CONV}",
    "train-safety": f"there there there out {SAFETY} --metrics m.json",
    "rollout": f"there there out {ROLLOUT} --metrics m.json",
    "rollout-dagger": f"there out {DRIVEN} --beta 0 --frames 9 --iteration 1",
    "evaluate": f"there there {TRACK} --starts 1 --strategies naive --drives d.csv "
    "--metrics m.json --workers 1",
    "errors": "there there there --tau 1 --measure steering --share 0.5 --figure f.png "
    "--metrics m.json",
    "judge": "there there there --figure f.png --metrics m.json",
    "film": f"there there {FOUND} --output out.gif --laps 1 --show-every 1",
    "watch": f"there there {FOUND} --save out.rrd",
    "compare-policies": f"there there there there {FOUND} --save out.rrd",
}


def test_each_command_that_runs_a_network_has_the_option() -> None:
    commands = typer.main.get_command(cli.commands([])).commands
    having = {n for n, of in commands.items() if any(p.name == "device" for p in of.params)}
    assert having == set(TYPED)


@pytest.mark.parametrize("command", TYPED)
def test_a_device_that_there_is_not_is_refused_before_anything_is_read(
    command: str, tmp_path: Path, refused: Callable[..., str]
) -> None:
    (tmp_path / "there").mkdir()
    error = refused(f"{command} {TYPED[command]} --device cuda:99")
    assert error.startswith("device is 'cuda:99', expected one that this machine has: ")


def test_the_processor_is_what_computes_by_default(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no recipe tells: what is made is the same, byte for byte."""
    monkeypatch.chdir(tmp_path)
    for name in ("D_0", "D_safe"):
        assert run(collect(name, 4)) == 0
    made = []
    for name, device in (("a", ""), ("b", "--device cpu")):
        for command in (
            f"train-primary D_0 {name}/primary {CONV}",
            f"train-safety {name}/primary D_safe D_0 {name}/safety {SAFETY}",
            f"rollout {name}/primary {name}/safety {name}/rollout {ROLLOUT}",
        ):
            assert run(f"{command} {device}") == 0
        made.append(tree(tmp_path / name))
    assert made[0] == made[1]
