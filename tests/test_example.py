"""The example's own pipeline is one that our commands understand."""

import shutil
from pathlib import Path

import pytest
import typer.main
from dvc.repo import Repo

from stages.__main__ import commands

ROOT = Path(__file__).parent.parent


@pytest.fixture
def example(tmp_path: Path) -> Path:
    names = ("dvc.yaml", "params.yaml", ".dvc/config")
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / "examples/metaworld" / name, tmp_path / name)
    config = tmp_path / ".dvc/config"
    config.write_text(config.read_text().replace("[core]", "[core]\n    no_scm = true"))
    return tmp_path


def test_every_command_of_the_example_is_one_of_ours(
    example: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With all that it needs, and nothing that it does not know."""
    monkeypatch.chdir(example)
    stages = [stage for stage in Repo().index.stages if stage.cmd]
    assert len(stages) == 3 + 4 * 3 + 2 * 4  # once, in each iteration, of each policy
    for stage in stages:
        read = [Path(dep.fs_path) for dep in stage.deps]
        for path in read:
            path.mkdir(parents=True)
        program, *words = stage.cmd.split()
        assert program == "safedagger"
        command = typer.main.get_command(commands(words)).commands[words[0]]
        command.make_context(words[0], words[1:])  # raises where it does not fit
        for path in read:
            path.rmdir()


def test_the_root_pipeline_knows_nothing_of_it() -> None:
    """`make repro` runs what is in dvc.yaml, and the example is a project of its own."""
    assert "metaworld" not in (ROOT / "dvc.yaml").read_text()
    assert (ROOT / "examples/metaworld/.dvc/config").is_file()
