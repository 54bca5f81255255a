"""Two cores run the suite: one thread a process, and no test fails for being slow."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # read once, when NumPy and PyTorch are imported
if sys.platform == "linux":
    os.environ.setdefault("MUJOCO_GL", "egl")  # else MuJoCo wants a display
settings.register_profile("suite", deadline=None, max_examples=50)
settings.load_profile("suite")


@pytest.fixture
def refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """Types a command in a folder, an empty one unless given: it is refused in one line, which this
    gives, and leaves nothing.
    """
    from tests.command import run
    from tests.files import tree

    def type_(command: str, folder: Path = tmp_path) -> str:
        monkeypatch.chdir(folder)
        before = sorted(folder.rglob("*")), tree(folder)
        capsys.readouterr()
        code, error = run(command), capsys.readouterr().err
        assert (code, error.count("\n")) == (2, 1)
        assert (sorted(folder.rglob("*")), tree(folder)) == before
        assert error.startswith("safedagger: ")
        return error.removeprefix("safedagger: ")

    return type_
