"""A command as it is typed, run in this process: LeRobot takes long to import."""

import sys

import pytest

from stages import __main__ as cli


def run(*words: object) -> int:
    """Call `safedagger` with these words; gives its exit code."""
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as exit_:
        patch.setattr(sys, "argv", ["safedagger", *map(str, words)])
        cli.main()
    assert isinstance(exit_.value.code, int)
    return exit_.value.code
