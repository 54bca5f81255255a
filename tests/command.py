"""A command as it is typed, run in this process: LeRobot takes long to import."""

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from stages import __main__ as cli


def run(command: str) -> int:
    """Call `safedagger` with what is typed behind it; gives its exit code."""
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as exit_:
        patch.setattr(sys, "argv", ["safedagger", *shlex.split(command)])
        cli.main()
    assert isinstance(exit_.value.code, int)
    return exit_.value.code


def typed(program: str, *words: str) -> None:
    """Call ours as `run` does, another by its script; it has to succeed."""
    if program == "safedagger":
        assert run(shlex.join(words)) == 0, words
    else:
        script = Path(sys.executable).parent / program
        done = subprocess.run([script, *words], check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
