"""Drives as CSV: what is written is read back, and what is wrong is named."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.evaluation.drives import COLUMNS, among, read_drives, table, write_drives
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import FIRST, drives, outcome

amounts = st.floats(0, 1e9)
counts = st.integers(0, 10**6)


@st.composite
def rows(draw: st.DrawFn) -> dict[str, Any]:
    takeover_frames, primary_frames = draw(counts), draw(st.integers(1, 10**6))
    return outcome(
        scenario=draw(st.sampled_from(["spruce", "yew", "random:12", "a, b"])),
        strategy=draw(st.sampled_from([str(each) for each in Strategy])),
        start=draw(counts),
        laps=draw(amounts),
        distance_m=draw(st.floats(-1e9, 1e9)),
        frames=takeover_frames + primary_frames,
        takeover_frames=takeover_frames,
        primary_frames=primary_frames,
        deviation_sum=draw(st.one_of(amounts, st.just(float("nan")))),
        takeovers=draw(counts),
    )


@given(written=st.lists(rows(), min_size=1, max_size=5))
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, written: list[dict]) -> None:
    path = tmp_path_factory.mktemp("drives") / "drives.csv"
    write_drives(path, table(written))
    pd.testing.assert_frame_equal(read_drives(path), table(written), check_exact=True)


def test_one_row_reads_as_expected(tmp_path: Path) -> None:
    row = outcome(damage=0.1, traffic=40.0, primary="ab", begun_with="cd")
    write_drives(tmp_path / "drives.csv", table([row]))
    header, line = (tmp_path / "drives.csv").read_text().splitlines()
    assert header == ",".join(row)
    assert (
        line
        == "yew,traffic,40.0,naive,0,1.5,900.0,0.1,0.0,500,0,500,0,0,5.0,1.0,road left,ab,cd,made up"
    )


def test_drives_are_told_apart_by_their_columns() -> None:
    found = among(
        drives(FIRST, starts=2), scenario="yew", strategy=["naive", "safe"], condition=("traffic",)
    )
    assert len(found) == 4
    assert set(found.scenario) == {"yew"} and set(found.condition) == {"traffic"}


WHOLE = "expected a whole number of at least 0"


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"scenario": ""}, "scenario is '', expected a name"),
        ({"traffic": "many"}, "traffic is 'many', expected a finite number"),
        (
            {"strategy": "greedy"},
            "strategy is 'greedy', expected one of reference, naive, safe, optimal, mixture",
        ),
        ({"laps": "nan"}, "laps is 'nan', expected a finite number"),
        ({"damage": "inf"}, "damage is 'inf', expected a finite number"),
        ({"damage": "none"}, "damage is 'none', expected a finite number"),
        ({"start": "1.5"}, f"start is '1.5', {WHOLE}"),
        ({"start": ""}, f"start is '', {WHOLE}"),
        ({"takeovers": "-1"}, f"takeovers is '-1', {WHOLE}"),
        ({"deviation_sum": "-1"}, "deviation_sum is '-1', expected a finite number of at least 0"),
        ({"primary_frames": "499"}, "frames is 500, expected takeover_frames + primary_frames"),
        ({"frames": "0", "primary_frames": "0"}, "frames is 0, expected at least 1"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, changes: dict[str, str], problem: str) -> None:
    path = tmp_path / "drives.csv"
    write_drives(path, table([outcome(), outcome(start=1)]))
    lines = path.read_text().splitlines()
    row = dict(zip(lines[0].split(","), lines[2].split(","), strict=True)) | changes
    path.write_text("\n".join([*lines[:2], ",".join(row.values())]))
    with pytest.raises(ValueError) as error:
        read_drives(path)
    assert str(error.value) == f"{path}, line 3: {problem}"


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    for name in COLUMNS:
        write_drives(tmp_path / f"{name}.csv", table([outcome()]).drop(columns=name))
        with pytest.raises(ValueError, match=f"line 1: no column '{name}', expected "):
            read_drives(tmp_path / f"{name}.csv")


@pytest.mark.parametrize(
    "content", [b"", b"laps\n1\n", b"\xff\xfe\x00", b'{"laps": 1}', b"a,b\n1,2\n1,2,3\n"]
)
def test_another_file_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "drives.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="expected") as error:
        read_drives(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_file_without_drives_and_no_file(tmp_path: Path) -> None:
    write_drives(tmp_path / "none.csv", table([outcome()])[:0])
    with pytest.raises(ValueError, match="no drives, expected at least one"):
        read_drives(tmp_path / "none.csv")
    with pytest.raises(FileNotFoundError, match=r"missing.csv: no such file, expected a CSV"):
        read_drives(tmp_path / "missing.csv")
