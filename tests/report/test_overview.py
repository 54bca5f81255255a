"""The results in a terminal are those of the report."""

from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.report.overview import HEADER, overview
from tests.command import run
from tests.evaluation.made_up import GROWING, SLOW, experiment, undriven
from tests.evaluation.written import write_run


def test_a_row_a_step_with_what_it_came_to() -> None:
    rows = list(overview(experiment({"safedagger": GROWING, "dagger": SLOW[:2]}, seeds=2)))
    assert [row[:2] for row in rows] == [
        *(["SafeDAgger", str(i)] for i in range(4)),
        ["DAgger", "0"],
        ["DAgger", "1"],
    ]
    assert dict(zip(HEADER, rows[1], strict=True)) == {
        "Run": "SafeDAgger",
        "Iteration": "1",
        "Seeds": "0, 1",
        "Laps, naive": "2.50 / 2.00",
        "Laps, safe": "3.00 / 3.00",
        "Takeover, safe": "5.0 % / 15.0 %",
        "Failed, naive": "48 of 48",
        "Queries so far": "3,000",
        "Labels in all": "11,600",
        "Failures while collecting": "0",
    }
    assert rows[3][6:] == ["0 of 48", "7,000", "15,600", "0"]


def test_what_was_not_driven_has_no_number() -> None:
    quiet = undriven(experiment({"safedagger": GROWING[:1]}), condition="traffic", strategy="naive")
    (row,) = overview(undriven(quiet, condition="no_traffic", strategy="safe"))
    assert row[3:6] == ["2.00 / -", "- / 3.00", "- / 20.0 %"]


def test_results_are_printed_whole_where_there_is_no_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path)
    assert run(f"results {tmp_path}") == 0
    header, *lines = capsys.readouterr().out.splitlines()
    assert all(name in header for name in HEADER)
    assert [line.split()[:2] for line in lines[:4]] == [["SafeDAgger", str(i)] for i in range(4)]


def test_no_results_are_one_line(tmp_path: Path, refused: Callable[..., str]) -> None:
    assert f"{tmp_path}: no seed_" in refused(f"results {tmp_path}")
