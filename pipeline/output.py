"""Outputs appear complete or not at all, and nothing of a command that was killed stays for long."""

import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

SCRATCH = ".safedagger-"
"""What the names of scratch folders begin with; git and DVC ignore them."""
_LOCK = ".lock"
_NEW = 60.0  # [s] that a folder is left alone whose lock may not be taken yet


@contextmanager
def new_directory(path: Path) -> Iterator[Path]:
    """A free path in a scratch folder beside `path`; what the block puts there becomes `path` if it
    ends well. Raises as `check_place`, before the block is entered.
    """
    check_place(path)
    with _scratch(path.parent) as scratch:
        yield scratch / path.name
        (scratch / path.name).rename(path)


def write_file(path: Path, content: bytes) -> None:
    """Write `content` aside and rename it to `path`; makes the folder where it is missing."""
    with _scratch(path.parent) as scratch:
        (scratch / "content").write_bytes(content)
        (scratch / "content").replace(path)


def check_place(*paths: Path | None) -> None:
    """Try, before any work is done, whether something new can be written at each of `paths`, but
    None. FileExistsError where there is something at one of them; ValueError where two are the same, a name
    is too long, a folder is a file, or cannot be written into.
    """
    taken: set[Path] = set()
    for path in filter(None, paths):
        whole = path.absolute()
        if whole in taken:
            raise ValueError(f"{path}: given twice, expected a path for each output")
        taken.add(whole)
        try:
            if os.path.lexists(path):
                raise FileExistsError(f"{path}: exists already, expected a new path")
            folder = next(parent for parent in whole.parents if os.path.lexists(parent))
            longest = max(len(os.fsencode(name)) for name in whole.relative_to(folder).parts)
            if longest > os.pathconf(folder, "PC_NAME_MAX"):
                raise ValueError(f"{path}: the name is too long, expected a shorter one")
            tempfile.TemporaryFile(dir=folder).close()
        except FileExistsError:
            raise
        except OSError as error:
            raise ValueError(f"{path}: nothing can be written there ({error.strerror})") from None


def seen_from(folder: Path, path: Path) -> str:
    """Where `path` lies, as a link in a file in `folder` says it."""
    return Path(os.path.relpath(path, folder)).as_posix()


@contextmanager
def _scratch(parent: Path) -> Iterator[Path]:
    """A folder in `parent`, so that the last step is a rename within one file system."""
    made = [folder for folder in (parent, *parent.parents) if not folder.exists()]
    parent.mkdir(parents=True, exist_ok=True)
    _sweep(parent)
    scratch = Path(tempfile.mkdtemp(prefix=SCRATCH, dir=parent))
    try:
        # The system lets go of the lock when the process ends, however it ends.
        with open(scratch / _LOCK, "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield scratch
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        with suppress(OSError):  # where something has become of it they are not empty
            for folder in made:
                folder.rmdir()


def _sweep(parent: Path) -> None:
    """Remove the scratch folders in `parent` of commands that were killed."""
    for scratch in parent.glob(f"{SCRATCH}*"):
        with suppress(OSError):  # somebody else may be sweeping, too
            if time.time() - scratch.stat().st_mtime < _NEW:
                continue
            with open(scratch / _LOCK, "a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(scratch, ignore_errors=True)
