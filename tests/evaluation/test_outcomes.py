"""Drives as CSV: what is written is read back, and what is wrong is named."""

from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.evaluation.outcomes import Outcome, read_outcomes, write_outcomes
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import drives, outcome

amounts = st.floats(0, 1e9)
counts = st.integers(0, 10**6)


@st.composite
def outcomes(draw: st.DrawFn) -> Outcome:
    takeover_frames, primary_frames = draw(counts), draw(st.integers(1, 10**6))
    return Outcome(
        track=draw(st.sampled_from(["spruce", "yew", "random:12"])),
        traffic=draw(st.integers(0, 40)),
        strategy=draw(st.sampled_from(list(Strategy))),
        start=draw(counts),
        laps=draw(amounts),
        damage=draw(amounts),
        frames=takeover_frames + primary_frames,
        takeover_frames=takeover_frames,
        squared_error_sum=draw(amounts),
        primary_frames=primary_frames,
        takeovers=draw(counts),
        switches=draw(counts),
        off_road=draw(st.booleans()),
    )


@given(written=st.lists(outcomes(), min_size=1, max_size=5))
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, written: list[Outcome]) -> None:
    path = tmp_path_factory.mktemp("drives") / "drives.csv"
    write_outcomes(path, written)
    assert read_outcomes(path) == written


def test_bytes_are_stable_and_nothing_else_is_left(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_outcomes(tmp_path / name / "drives.csv", drives(0))
    first, second = sorted(tmp_path.rglob("*.csv"))
    assert first.read_bytes() == second.read_bytes()
    assert [file.name for file in (tmp_path / "a").iterdir()] == ["drives.csv"]


def test_one_row_reads_as_expected(tmp_path: Path) -> None:
    write_outcomes(tmp_path / "drives.csv", [outcome(damage=0.1, traffic=40)])
    header, row = (tmp_path / "drives.csv").read_text().splitlines()
    assert header == ",".join(field.name for field in fields(Outcome))
    assert row == "yew,40,naive,0,1.5,0.1,500,0,5.0,500,0,0,true"


@pytest.mark.parametrize(
    ("column", "value", "problem"),
    [
        ("track", "", "track is '', expected a name"),
        ("traffic", "-1", "traffic is -1, expected at least 0"),
        ("traffic", "many", "traffic is 'many', expected a whole number"),
        (
            "strategy",
            "greedy",
            "strategy is 'greedy', expected one of reference, naive, safe, optimal, mixture",
        ),
        ("laps", "nan", "laps is nan, expected a finite number of at least 0"),
        ("laps", "-0.5", "laps is -0.5, expected a finite number of at least 0"),
        ("damage", "inf", "damage is inf, expected a finite number of at least 0"),
        ("damage", "none", "damage is 'none', expected a number"),
        ("frames", "0", "frames is 0, expected at least 1"),
        ("primary_frames", "499", "takeover_frames + primary_frames is 499, expected 500"),
        ("off_road", "yes", "off_road is 'yes', expected true or false"),
        ("off_road", "true,1", "14 values, expected 13"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, column: str, value: str, problem: str) -> None:
    path = tmp_path / "drives.csv"
    write_outcomes(path, [outcome(), outcome(start=1)])
    lines = path.read_text().splitlines()
    row = dict(zip(lines[0].split(","), lines[2].split(","), strict=True)) | {column: value}
    path.write_text("\n".join([*lines[:2], ",".join(row.values())]))
    with pytest.raises(ValueError) as error:
        read_outcomes(path)
    assert str(error.value) == f"{path}, line 3: {problem}"


@pytest.mark.parametrize("content", [b"", b"laps\n1\n", b"\xff\xfe\x00", b'{"laps": 1}'])
def test_another_file_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "drives.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="expected") as error:
        read_outcomes(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_file_without_drives_and_no_file(tmp_path: Path) -> None:
    write_outcomes(tmp_path / "none.csv", [])
    with pytest.raises(ValueError, match="no drives, expected at least one"):
        read_outcomes(tmp_path / "none.csv")
    with pytest.raises(FileNotFoundError, match=r"missing.csv: no such file, expected a CSV"):
        read_outcomes(tmp_path / "missing.csv")
