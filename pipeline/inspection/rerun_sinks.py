"""Where recordings go: into one file, or to a viewer on this machine."""

import os
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from urllib.parse import quote

import rerun as rr
import rerun.blueprint as rrb

from pipeline.inspection.rerun_log import Connect
from pipeline.output import check_place, new_directory

LOOPBACK = "127.0.0.1"  # Rerun's own default is to be open to the whole network
STARTING = 30.0  # [s] that a viewer may take to start
_RERUN = Path(rr.__file__).parents[1] / "rerun_cli" / "rerun"
_ENVIRONMENT = {**os.environ, "RERUN_ANALYTICS": "0"}
_BROKE = (
    "the viewer broke down: its window needs a display, a page for a browser or a file does not"
)


@dataclass(frozen=True)
class Sink:
    """A place where recordings can go."""

    connect: Connect
    """Connects a new stream to it."""
    is_open: Callable[[], bool]
    """Whether it still takes anything: a viewer may be closed at any time."""
    page: str | None = None
    """The address of a page that shows it."""


@contextmanager
def into_file(path: Path, blueprint: rrb.Blueprint) -> Iterator[Sink]:
    """One file at `path`, which appears complete or not at all.

    Args:
        path: a new file.
        blueprint: where the viewer shows what.

    Raises:
        FileExistsError: there is something at `path`.
        ValueError: its name does not end in .rrd.
    """
    if path.suffix != ".rrd":
        raise ValueError(f"{path}: expected a name that ends in .rrd")
    with new_directory(path) as whole:
        parts: list[Path] = []

        def connect(recording: rr.RecordingStream) -> None:
            part = whole.with_name(f"{len(parts)}_{path.name}")
            recording.save(part, default_blueprint=None if parts else blueprint)
            parts.append(part)

        yield Sink(connect, lambda: True)
        # merge holds all in memory; `rrd route` would not, but panics on some files (0.33.1)
        merge: list[str | Path] = [_RERUN, "rrd", "merge", "--output", whole, *parts]
        subprocess.run(merge, check=True, capture_output=True, env=_ENVIRONMENT)
        check_place(path)


@contextmanager
def into_viewer(blueprint: rrb.Blueprint, *, web: bool) -> Iterator[Sink]:
    """Starts a viewer that only this machine can reach, and in the end waits until it is closed.

    Connecting to a viewer that was closed ends the block.

    Args:
        blueprint: where the viewer shows what.
        web: serve a page to a browser, instead of opening a window.

    Raises:
        ValueError: the viewer did not start, or broke down.
    """
    port, page = _free_port(), _free_port()
    data = f"rerun+http://{LOOPBACK}:{port}/proxy"
    how = ["--serve-web", "--web-viewer-port", str(page)] if web else ["--hide-welcome-screen"]
    process = subprocess.Popen(
        [_RERUN, "--bind", LOOPBACK, "--port", str(port), *how],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=_ENVIRONMENT,
    )
    address = f"http://{LOOPBACK}:{page}/?url={quote(data, safe='')}"
    connected = count()

    def is_open() -> bool:
        return process.poll() is None

    def connect(recording: rr.RecordingStream) -> None:
        if not is_open():
            raise RuntimeError("the viewer was closed")
        recording.connect_grpc(data, default_blueprint=None if next(connected) else blueprint)

    try:
        _await(process, port)
        try:
            yield Sink(connect, is_open, address if web else None)
        except RuntimeError:
            if is_open():
                raise
        if process.wait() > 0:
            raise ValueError(_BROKE)
    finally:
        process.terminate()
        process.wait()


def _await(process: subprocess.Popen[bytes], port: int) -> None:
    """Return when the viewer listens."""
    end = time.monotonic() + STARTING
    while time.monotonic() < end and process.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex((LOOPBACK, port)) == 0:
                return
        time.sleep(0.05)
    raise ValueError(_BROKE)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
