"""Where a recording goes: a file that is whole or not there, a viewer that nobody else can reach."""

import os
import re
import socket
from pathlib import Path

import numpy as np
import pytest

from pipeline.inspection.excerpts import Excerpt
from pipeline.inspection.rerun_blueprints import drive_blueprint
from pipeline.inspection.rerun_log import log_excerpt
from pipeline.inspection.rerun_sinks import into_file, into_viewer
from tests.episodes import random_episode

BLUEPRINT = drive_blueprint(10)
WHERE = "drive on alder with 3 other cars"
EXCERPT = Excerpt("title", "name", random_episode(np.random.default_rng(0), 5, task=WHERE), 0)


def test_a_file_is_never_overwritten_and_never_half_there(tmp_path: Path) -> None:
    (tmp_path / "mine.rrd").write_text("precious")
    refused = ("mine.rrd", FileExistsError, "exists"), ("mine.txt", ValueError, r"ends in \.rrd")
    for name, error, words in refused:
        with pytest.raises(error, match=words), into_file(tmp_path / name, BLUEPRINT):
            pytest.fail("the file was begun")
    with pytest.raises(KeyboardInterrupt), into_file(tmp_path / "new.rrd", BLUEPRINT) as sink:
        log_excerpt(EXCERPT, sink.connect, fps=10)
        raise KeyboardInterrupt
    with pytest.raises(FileExistsError), into_file(tmp_path / "late.rrd", BLUEPRINT) as sink:
        log_excerpt(EXCERPT, sink.connect, fps=10)
        (tmp_path / "late.rrd").write_text("precious")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["late.rrd", "mine.rrd"]
    assert {path.read_text() for path in tmp_path.iterdir()} == {"precious"}


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="lists who listens, on Linux")
def test_only_this_machine_reaches_the_page() -> None:
    with pytest.raises(KeyboardInterrupt), into_viewer(BLUEPRINT, web=True) as sink:
        log_excerpt(EXCERPT, sink.connect, fps=10)
        ports = [int(port) for port in re.findall(r"127\.0\.0\.1(?::|%3A)(\d+)", sink.page or "")]
        assert len(ports) == 2
        assert [listening(port) for port in ports] == [{"0100007F"}, {"0100007F"}]
        assert sink.is_open()
        raise KeyboardInterrupt
    assert not sink.is_open()
    for port in ports:
        with socket.socket() as probe:
            assert probe.connect_ex(("127.0.0.1", port)) != 0


def test_the_page_is_where_it_is_wanted_and_its_data_is_next() -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        taken = probe.getsockname()[1]
        probe.listen()
        for port in (taken, taken - 1):
            with (
                pytest.raises(ValueError, match=f"port {taken}: .* expected a free one"),
                into_viewer(BLUEPRINT, web=True, port=port),
            ):
                pass
    with pytest.raises(KeyboardInterrupt), into_viewer(BLUEPRINT, web=True, port=taken) as sink:
        assert sink.ports == (taken, taken + 1)
        assert f"http://127.0.0.1:{taken}/" in (sink.page or "")
        raise KeyboardInterrupt


def listening(port: int) -> set[str]:
    """The addresses, in hexadecimal, that are listened to on a port."""
    tables = [table.read_text().splitlines()[1:] for table in Path("/proc/net").glob("tcp*")]
    lines = [line.split() for table in tables for line in table]
    sockets = [(*line[1].split(":"), line[3]) for line in lines]
    return {host for host, where, state in sockets if int(where, 16) == port and state == "0A"}


def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pipeline.inspection.rerun_sinks._ENVIRONMENT",
        {"PATH": os.environ["PATH"], "RERUN_ANALYTICS": "0"},
    )
    with pytest.raises(ValueError, match="use --web or --save"), into_viewer(BLUEPRINT, web=False):
        pass
