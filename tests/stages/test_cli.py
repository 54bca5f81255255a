"""The commands as a user meets them: quick help, and one line for bad input."""

import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from stages.__main__ import STAGES
from tests.command import run

HEAVY = {"torch", "lerobot", "pybullet", "numpy", "matplotlib", "datasets"}
DRIVES = "--tracks alder --traffic 2 --seconds 1 --action-repeat 2 --workers 1"


@pytest.mark.parametrize("stage", STAGES)
def test_each_stage_explains_itself(stage: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(f"{stage} --help") == 0
    assert f"safedagger {stage}" in capsys.readouterr().out


def test_the_list_of_commands_shows_each_with_a_whole_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run("--help") == 0
    lines = capsys.readouterr().out.split("Commands:\n")[1].splitlines()
    assert [line.split()[0] for line in lines] == list(STAGES)
    assert all(line.endswith(".") and not line.endswith("...") for line in lines)
    assert all(line.count("(") == line.count(")") for line in lines)


def test_the_version_is_the_projects(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--version") == 0
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    assert capsys.readouterr().out == f"safedagger {project['version']}\n"


@pytest.mark.parametrize(
    ("task", "shown", "hidden"),
    [
        ("", "--offset-spread", "--length"),
        ("--task driving", "--offset-spread", "--length"),
        ("--task tests.stages.pendulum:Pendulum", "--length", "--tracks"),
    ],
)
def test_the_settings_of_a_task_are_options_of_the_commands_that_drive(
    task: str, shown: str, hidden: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of the car by default; of whatever task is named otherwise."""
    assert run(f"collect {task} --help") == 0
    told = capsys.readouterr().out
    assert shown in told and "--episodes" in told and hidden not in told


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ("--tracks nowhere", "nowhere"),
        ("--traffic -1", "--traffic"),
        ("--traffic 9000", "9000"),
        ("--seconds -3", "--seconds"),
        ("--seconds nan", "seconds"),
        ("--seconds 0", "seconds is 0.0, expected a number above 0"),
        ("--laps 0", "laps is 0.0, expected a number above 0"),
        ("--episodes 0", "--episodes"),
        ("--action-repeat 7", "action_repeat"),
        ("--purpose fun", "--purpose"),
        ("--workers 0", "--workers"),
        ("--task nowhere", "task 'nowhere': expected"),
        ("--task json:dumps", "task 'json:dumps' is <function"),
        ("--task tests.stages.pendulum:Nothing", "task 'tests.stages.pendulum:Nothing': expected"),
    ],
)
def test_collect_refuses_nonsense(change: str, named: str, refused: Callable[..., str]) -> None:
    assert named in refused(f"collect out {DRIVES} --episodes 1 {change}")


def test_an_output_that_exists_is_left_alone(tmp_path: Path, refused: Callable[..., str]) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("precious")
    assert "exists" in refused(f"collect out {DRIVES}")
    assert (tmp_path / "out" / "mine").read_text() == "precious"


@pytest.mark.parametrize("option", ["--drives", "--metrics"])
@pytest.mark.parametrize("place", ["/proc/x.csv", "n" * 300])
def test_a_place_that_cannot_be_written_is_found_out_before_the_driving(
    option: str, place: str, tmp_path: Path, refused: Callable[..., str]
) -> None:
    """The policies are no policies, too: nobody opens them yet."""
    (tmp_path / "policy").mkdir()
    places = f"--drives drives.csv --metrics metrics.json {option} {place}"
    error = refused(f"evaluate policy policy {DRIVES} --laps 1 --starts 1 {places}")
    assert error.startswith(f"{place}: ")


WRONG = """
import sys
from stages.__main__ import main
for command in sys.argv[1].splitlines():
    sys.argv[1:] = command.split()
    try:
        main()
    except SystemExit as end:
        assert end.code == 2
print(*{module.split(".")[0] for module in sys.modules})
"""


def test_a_wrong_path_is_found_out_before_anything_heavy_is_imported(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    typed = (
        "select missing out",
        "sample missing out --frames 3 --seed 0",
        "split missing out other --share 0.1",
        "merge there missing out",
        "ledger missing there --metrics out",
        "inspect missing",
        "contact-sheet missing out --frames 3",
        "compare there missing",
        f"collect there {DRIVES}",
        f"rollout there missing out --queries 1 --frames 1 {DRIVES}",
        "watch missing --strategy naive --seed 0",
        "train-primary missing out",
        "train-primary there there",
        "train-safety there missing missing out",
        "evaluate missing --metrics m --drives d",
        "errors missing there there --figure x.png --metrics m",
        "judge missing there there --figure x.png --metrics m",
    )
    done = subprocess.run(
        [sys.executable, "-c", WRONG, "\n".join(typed)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stderr.splitlines()
    assert len(lines) == len(typed)
    assert all("'missing' does not exist" in line or " there: exists" in line for line in lines)
    assert not (HEAVY - {"numpy"} | {"pyarrow", "pandas", "scipy", "rerun"}) & set(
        done.stdout.split()
    )
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


LIMITED = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
from stages.__main__ import main
main()
"""


def test_a_fault_of_the_machine_is_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    """As a full disk, which needs root to make: files that may not grow any further."""
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, "collect", str(tmp_path / "out"), *DRIVES.split()],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert re.fullmatch(r"safedagger: .*File too large\n", done.stderr)
    assert list(tmp_path.iterdir()) == []
