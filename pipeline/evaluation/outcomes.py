"""One evaluated drive as one row of a CSV file."""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from pipeline.output import write_file
from pipeline.rollout.strategies import Strategy

_STRATEGIES = ", ".join(Strategy)


@dataclass(frozen=True)
class Outcome:
    """What came of one drive on one track."""

    track: str
    traffic: int
    """other cars on the track"""
    strategy: str
    """one of Strategy"""
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
    takeovers: int
    """how often the reference began to drive"""
    switches: int
    """how often the driver changed, either way"""
    off_road: bool
    """the drive ended by leaving the road"""

    def __post_init__(self) -> None:
        if not self.track or set(self.track) & set(',"\r\n'):
            raise ValueError(f"track is {self.track!r}, expected a name")
        for name in ("laps", "damage", "squared_error_sum"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} is {value}, expected a finite number of at least 0")
        for name in (
            "traffic",
            "start",
            "takeover_frames",
            "primary_frames",
            "takeovers",
            "switches",
        ):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected at least 0")
        if self.strategy not in list(Strategy):
            raise ValueError(f"strategy is {self.strategy!r}, expected one of {_STRATEGIES}")
        if self.frames < 1:
            raise ValueError(f"frames is {self.frames}, expected at least 1")
        driven = self.takeover_frames + self.primary_frames
        if driven != self.frames:
            raise ValueError(
                f"takeover_frames + primary_frames is {driven}, expected {self.frames}"
            )


def write_outcomes(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write drives as CSV, in their order; equal drives give equal bytes."""
    rows = [asdict(outcome) | {"off_road": str(outcome.off_road).lower()} for outcome in outcomes]
    # str keeps every bit of a float
    lines = [",".join(_COLUMNS), *(",".join(map(str, row.values())) for row in rows)]
    write_file(path, "".join(f"{line}\n" for line in lines).encode())


def read_outcomes(path: Path) -> list[Outcome]:
    """Read what `write_outcomes` wrote.

    Raises:
        FileNotFoundError: no such file.
        ValueError: not such a file; names the line.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file, expected a CSV of evaluated drives")
    try:
        lines = path.read_text().splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not text, expected a CSV of evaluated drives") from None
    if not lines or lines[0] != ",".join(_COLUMNS):
        found = lines[0] if lines else ""
        raise ValueError(f"{path}, line 1: found {found!r}, expected {','.join(_COLUMNS)!r}")
    outcomes = [_parse(line, f"{path}, line {i}") for i, line in enumerate(lines[1:], start=2)]
    if not outcomes:
        raise ValueError(f"{path}: no drives, expected at least one")
    return outcomes


def _parse(line: str, where: str) -> Outcome:
    row = line.split(",")  # no value of ours holds a comma or a quote
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
    "strategy": ("a name", str),
    "laps": _NUMBER,
    "damage": _NUMBER,
    "squared_error_sum": _NUMBER,
    "off_road": ("true or false", {"true": True, "false": False}.__getitem__),
}
