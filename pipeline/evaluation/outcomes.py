"""One evaluated drive as one row of a CSV file."""

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from pipeline.evaluation.writing import write_file
from pipeline.policies.strategies import Strategy


@dataclass(frozen=True)
class Outcome:
    """What came of one drive on one track."""

    track: str
    traffic: int
    """other cars on the track"""
    strategy: Strategy
    start: int
    """number of the start: equal starts are equal situations, whoever drives"""
    laps: float
    """distance driven, fractional, >= 0"""
    damage: float
    """[m^2/s^2] over the whole drive"""
    frames: int
    """frames driven, >= 1"""
    takeover_frames: int
    """of them, driven by the reference"""
    squared_error_sum: float
    """sum of the deviation over `primary_frames`"""
    primary_frames: int
    """driven by the primary; in each the reference was asked only to measure the deviation"""
    off_road: bool
    """the drive ended by leaving the road"""

    def __post_init__(self) -> None:
        for name in ("laps", "damage", "squared_error_sum"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} is {value}, expected a finite number of at least 0")
        for name in ("traffic", "start", "takeover_frames", "primary_frames"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected at least 0")
        if self.frames < 1:
            raise ValueError(f"frames is {self.frames}, expected at least 1")
        driven = self.takeover_frames + self.primary_frames
        if driven != self.frames:
            raise ValueError(f"takeover_frames + primary_frames is {driven}, expected {self.frames}")


def write_outcomes(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write drives as CSV, in their order; equal drives give equal bytes."""
    text = io.StringIO()
    writer = csv.DictWriter(text, _COLUMNS, lineterminator="\n")
    writer.writeheader()
    for outcome in outcomes:
        # repr keeps every bit of a float; lower case because JSON and CSV readers agree on it
        row = asdict(outcome) | {"off_road": str(outcome.off_road).lower()}
        writer.writerow(row)
    write_file(path, text.getvalue().encode())


def read_outcomes(path: Path) -> list[Outcome]:
    """Read what `write_outcomes` wrote.

    Raises:
        FileNotFoundError: no such file.
        ValueError: not such a file; names the line.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file, expected a CSV of evaluated drives")
    with path.open(newline="") as file:
        reader = csv.reader(file)
        header = next(reader, [])
        if header != _COLUMNS:
            raise ValueError(
                f"{path}, line 1: found {','.join(header)!r}, expected {','.join(_COLUMNS)!r}"
            )
        outcomes = [_parse(row, f"{path}, line {reader.line_num}") for row in reader]
    if not outcomes:
        raise ValueError(f"{path}: no drives, expected at least one")
    return outcomes


def _parse(row: list[str], where: str) -> Outcome:
    if len(row) != len(_COLUMNS):
        raise ValueError(f"{where}: {len(row)} values, expected {len(_COLUMNS)}")
    values: dict[str, Any] = {}
    for name, text in zip(_COLUMNS, row, strict=True):
        expected, parse = _PARSERS.get(name, ("a whole number", int))
        try:
            values[name] = parse(text)
        except (ValueError, KeyError):
            raise ValueError(f"{where}: {name} is {text!r}, expected {expected}") from None
    try:
        return Outcome(**values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


_COLUMNS = [field.name for field in fields(Outcome)]
_NUMBER: tuple[str, Callable[[str], Any]] = ("a number", float)
_PARSERS: dict[str, tuple[str, Callable[[str], Any]]] = {
    "track": ("a name", str),
    "strategy": (f"one of {', '.join(Strategy)}", Strategy),
    "laps": _NUMBER,
    "damage": _NUMBER,
    "squared_error_sum": _NUMBER,
    "off_road": ("true or false", {"true": True, "false": False}.__getitem__),
}
