"""Outputs appear complete or not at all."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def new_directory(path: Path) -> Iterator[Path]:
    """A free path in a scratch folder beside `path`; what the block puts there becomes `path` if it
    ends well.

    Raises:
        FileExistsError: there is something at `path`, before the block is entered.
    """
    refuse_existing(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    # beside it, so that the last step is a rename within one file system
    scratch = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        yield scratch / path.name
        (scratch / path.name).rename(path)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def refuse_existing(path: Path) -> None:
    """Raise FileExistsError if there is anything at `path`."""
    if path.exists() or path.is_symlink():
        raise FileExistsError(f"{path}: exists already, expected a new path")
