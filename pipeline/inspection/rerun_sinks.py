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
_BROKE = "the viewer broke down: where there is no display for its window, use --web or --save"


@dataclass(frozen=True)
class Sink:
    """A place where recordings can go."""

    connect: Connect
    """Connects a new stream to it."""
    is_open: Callable[[], bool]
    """Whether it still takes anything: a viewer may be closed at any time."""
    page: str | None = None
    """The address of a page that shows it."""
    ports: tuple[int, int] = (0, 0)
    """Of the page, and of the data that it asks for."""


@contextmanager
def into_file(path: Path, blueprint: rrb.Blueprint) -> Iterator[Sink]:
    """One file at `path`, which appears complete or not at all; ValueError unless its name ends in .rrd,
    else as `new_directory`.
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
def into_viewer(blueprint: rrb.Blueprint, *, web: bool, port: int = 0) -> Iterator[Sink]:
    """Starts a viewer that only this machine can reach, and in the end waits until it is closed.

    Connecting to a viewer that was closed ends the block. With `web` it serves a page to a browser,
    instead of opening a window, at `port`; its data has the next one; 0: any two. ValueError where one
    of them is taken, and where the viewer did not start, or broke down.
    """
    page, behind = _free_port(port), _free_port(port + 1 if port else 0)
    data = f"rerun+http://{LOOPBACK}:{behind}/proxy"
    how = ["--serve-web", "--web-viewer-port", str(page)] if web else ["--hide-welcome-screen"]
    process = subprocess.Popen(
        [_RERUN, "--bind", LOOPBACK, "--port", str(behind), *how],
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
        _await(process, behind)
        try:
            yield Sink(connect, is_open, address if web else None, (page, behind))
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


def _free_port(wanted: int) -> int:
    with socket.socket() as probe:
        try:
            probe.bind((LOOPBACK, wanted))
        except (OSError, OverflowError) as error:
            raise ValueError(f"port {wanted}: {error}, expected a free one") from None
        return int(probe.getsockname()[1])
