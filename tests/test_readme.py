"""What the README tells its readers to type."""

import shlex
import sys
from pathlib import Path

import pytest

from stages import __main__ as cli

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
STAGES = [path for path in ROOT.glob("stages/*.py") if "@app.command" in path.read_text()]
# what has more than one iteration
OF_A_RUN = {"report", "errors", "inspect", "compare", "compare-policies", "watch"}


def commands(heading: str) -> list[list[str]]:
    """The `safedagger` commands in the indented blocks under a heading."""
    section = README.split(f"## {heading}\n")[1].split("\n## ")[0]
    code = "\n".join(line[4:] for line in section.splitlines() if line.startswith("    "))
    lines = code.replace("\\\n", " ").splitlines()
    return [shlex.split(line) for line in lines if line.startswith("safedagger ")]


def test_one_iteration_by_hand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every command as printed, in this process: LeRobot takes long to import."""
    from pipeline.data.dataset import Dataset

    monkeypatch.chdir(tmp_path)
    typed = commands("One stage by hand")
    for command in typed:
        monkeypatch.setattr(sys, "argv", command)
        with pytest.raises(SystemExit) as exit_:
            cli.main()
        assert exit_.value.code == 0, (command, capsys.readouterr().err)
    of_an_iteration = {path.stem.replace("_", "-") for path in STAGES} - OF_A_RUN
    assert {command[1] for command in typed} == of_an_iteration
    for name in ("new_1", "new_dagger_1"):
        assert len(Dataset.open(Path("mine", name))) == 50
