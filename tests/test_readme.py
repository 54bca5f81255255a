"""What the README tells its readers to type."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command import typed

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
OWN = (ROOT / "docs/use-your-own.md").read_text()
STAGES = [path for path in ROOT.glob("stages/*.py") if "@app.command" in path.read_text()]
# what has more than one iteration
OF_A_RUN = {
    "plan",
    "runs",
    "report",
    "results",
    "errors",
    "inspect",
    "compare",
    "compare-policies",
    "watch",
}


PROGRAMS = ("safedagger", "lerobot-train")


def commands(page: str, heading: str) -> list[list[str]]:
    """The calls of PROGRAMS in the indented blocks under a heading."""
    section = page.split(f"## {heading}\n")[1].split("\n## ")[0]
    code = "\n".join(line[4:] for line in section.splitlines() if line.startswith("    "))
    calls = [shlex.split(line) for line in code.replace("\\\n", " ").splitlines()]
    return [call for call in calls if call and call[0] in PROGRAMS]


@pytest.fixture(scope="module")
def by_hand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where every command was typed as printed."""
    root = tmp_path_factory.mktemp("by_hand")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        for command in commands(README, "One stage by hand"):
            typed(*command)
    return root


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What LeRobot's commands look for, as it is installed; built from a copy, as setuptools leaves
    files where it builds."""
    shutil.copytree(ROOT / "plugin", tmp_path / "plugin")
    pip = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--no-index",
        "--no-build-isolation",
        "--no-deps",
    ]
    subprocess.run([*pip, "--target", tmp_path / "site", tmp_path / "plugin"], check=True)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(ROOT), str(tmp_path / "site"))))


def test_one_iteration_by_hand(by_hand: Path) -> None:
    from pipeline.data.dataset import Dataset

    of_an_iteration = {path.stem.replace("_", "-") for path in STAGES} - OF_A_RUN
    called = commands(README, "One stage by hand")
    assert {command[1] for command in called} == of_an_iteration
    for name in ("new_1", "new_dagger_1"):
        assert len(Dataset.open(by_hand / "mine" / name)) == 50


def test_a_rule_of_ones_own_drives_as_the_page_shows(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (ROOT / "docs/extending.md").read_text()
    monkeypatch.chdir(by_hand)
    exec("\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL)), {"__name__": "page"})
    told = [line.split() for line in capsys.readouterr().out.splitlines()]
    queries, frames = (sum(int(line[n]) for line in told) for n in (0, 3))
    assert (queries, frames) == (50, 100)


def test_the_demo_films_and_records_a_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As make calls it, but for the rest of the lap."""
    make = ["make", "--dry-run", "--old-file=.venv/.ready", "demo"]
    recipe = subprocess.run(make, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(ROOT / "examples")
    for line in recipe.splitlines()[1:]:
        typed(*shlex.split(line), "--laps", "0.1")
    assert {path.name for path in tmp_path.iterdir()} == {"examples", "demo.gif", "demo.rrd"}
    assert capsys.readouterr().out.count("ended: laps done") == 2


@pytest.mark.usefixtures("plugin")
def test_our_primaries_are_trained_by_lerobots_own_command(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By type and by path: what it has saved drives, and is not what it began with."""
    from pipeline.policies.loading import weights_sha256

    monkeypatch.chdir(by_hand)
    for command in commands(OWN, "Our primaries, trained by LeRobot"):
        typed(*command)
    assert json.loads(Path("mine/by_lerobot.json").read_text())["naive"]["traffic"]["frames"] > 0
    further = Path("mine/further_by_lerobot/checkpoints/last/pretrained_model")
    assert weights_sha256(further) != weights_sha256(Path("mine/primary_0"))
