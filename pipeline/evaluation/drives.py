"""Evaluated drives as one table, a row a drive.

Beside `COLUMNS` it has what the task says of a drive: the settings in which its conditions differ,
and what the drive has come to, such as "laps" or "success".
"""

import math
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd

from pipeline.metric import DRIVES
from pipeline.output import write_file
from pipeline.rollout.strategies import Strategy

SITUATION = ("scenario", "start")
"""Equal ones are equal situations, whoever drives."""
COUNTS = ("start", "frames", "takeover_frames", "primary_frames", "takeovers", "switches")
"""Number of the start; frames in all, of them by the reference and by the primary; how often the
reference began to drive, and how often the driver changed, either way.
"""
NAMES = ("scenario", "condition", "strategy", "ended", "primary", "begun_with", "processor")
"""In which one of the task's conditions it was driven; by which strategy; why it was over; the
SHA-256 of the weights of the primary that drove, and of the first that these were trained on from;
and on which processor. What is not known is "unknown".
"""
DEVIATION = "deviation_sum"
"""Over `primary_frames`; NaN where the reference cannot be looked up."""
COLUMNS = (*NAMES, *COUNTS, DEVIATION)


def table(rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """Drives as a table, with `DRIVES`."""
    return pd.DataFrame(list(rows)).assign(**{DRIVES: 1})


def write_drives(path: Path, drives: pd.DataFrame) -> None:
    """Write a table of drives as CSV; equal ones give equal bytes, and every bit of a float is kept."""
    text = drives.drop(columns=DRIVES).to_csv(index=False, lineterminator="\n")
    write_file(path, text.encode())


def read_drives(path: Path) -> pd.DataFrame:
    """Read what `write_drives` wrote; FileNotFoundError where there is no file, and a ValueError that
    names the line where it is not such a file.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file, expected a CSV of evaluated drives")
    try:
        found = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (ValueError, pd.errors.ParserError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"{path}: {reason}, expected a CSV of evaluated drives") from None
    missing = [name for name in COLUMNS if name not in found]
    if missing:
        raise ValueError(f"{path}, line 1: no column {missing[0]!r}, expected {','.join(COLUMNS)}")
    if found.empty:
        raise ValueError(f"{path}: no drives, expected at least one")
    for name in found.columns.drop(list(NAMES)):
        found[name] = _numbers(path, found[name])
    _check(path, found, "scenario", found.scenario.astype(bool), "a name")
    strategies = list(Strategy)
    _check(
        path, found, "strategy", found.strategy.isin(strategies), f"one of {', '.join(strategies)}"
    )
    _check(path, found, "frames", found.frames >= 1, "at least 1")
    driven = found.takeover_frames + found.primary_frames == found.frames
    _check(path, found, "frames", driven, "takeover_frames + primary_frames")
    return found.assign(**{DRIVES: 1})


def column(drives: pd.DataFrame, told: str) -> "pd.Series[Any]":
    """What a `metric.Metric` takes of each drive: a column, or what an expression of them comes to."""
    return drives[told] if told in drives else cast("pd.Series[Any]", drives.eval(told))


def among(drives: pd.DataFrame, **values: Any) -> pd.DataFrame:
    """The drives whose columns have these values; of a list or tuple, one of them."""
    kept = np.ones(len(drives), bool)
    for name, value in values.items():
        wanted = value if isinstance(value, list | tuple) else [value]
        kept &= drives[name].isin(wanted).to_numpy()
    return drives[kept]


def each_once(drives: pd.DataFrame) -> pd.DataFrame:
    """Those of one run for each step of a seed: runs share the supervised stage and its drives."""
    first = drives.groupby(["seed", "step"]).run.transform("first")
    return drives[drives.run == first]


def _numbers(path: Path, texts: pd.Series) -> pd.Series:
    """A column of numbers; Python's own parser keeps every bit."""
    name = str(texts.name)
    kind, words = (int, "a whole number") if name in COUNTS else (float, "a finite number")
    numbers = texts.map(partial(_parse, kind))
    known = (texts != "") | (name in COUNTS)
    positive = name in (*COUNTS, DEVIATION)
    good = numbers.notna() & (numbers.ge(0) | (not positive)) | ~known
    _check(path, texts.to_frame(), name, good, f"{words} of at least 0" if positive else words)
    return numbers.astype(kind)


def _parse(kind: type, text: str) -> float | None:
    try:
        number = kind(text)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


def _check(path: Path, rows: pd.DataFrame, name: str, good: Any, expected: str) -> None:
    """Raise a ValueError that names the first line that is not good."""
    bad = np.flatnonzero(~np.asarray(good, bool))
    if len(bad):
        value = rows[name].astype(object).iloc[bad[0]]
        raise ValueError(f"{path}, line {bad[0] + 2}: {name} is {value!r}, expected {expected}")
