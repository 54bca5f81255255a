"""Metrics as files."""

import json
import math
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from pipeline.metric import Metric, shown
from pipeline.output import write_file


def write_metrics(path: Path, metrics: Mapping[str, Any]) -> None:
    """Write metrics as strict JSON for `dvc metrics`.

    Sorted keys, floats rounded to 6 significant digits, and null for what has no finite value.
    """
    text = json.dumps(_strict(metrics), indent=2, sort_keys=True, allow_nan=False)
    write_file(path, (text + "\n").encode())


def write_rows(path: Path, row: Mapping[str, Any], metrics: Mapping[str, Metric]) -> None:
    """Write what was measured once, a row of a table, and of it the metrics that DVC shows: it leaves
    out lists, as the one that the row is in.
    """
    headline = {name: row[each.part] for name, each in shown(metrics, "dvc").items()}
    write_metrics(path, {**headline, "rows": [row]})


def write_curve(path: Path, epochs: Sequence[Mapping[str, float]]) -> None:
    """Write the metrics of a training's epochs, the same in each, as CSV for `dvc plots`: a row each.

    Rounded as by `write_metrics`.
    """
    rows = [epochs[0].keys(), *(map(str, _strict(epoch).values()) for epoch in epochs)]
    write_file(path, "".join(f"{','.join(row)}\n" for row in rows).encode())


def _strict(value: Any) -> Any:
    """The same in JSON's own types; NumPy's numbers are Integral and Real too."""
    if isinstance(value, Mapping):
        return {str(key): _strict(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_strict(item) for item in value]
    if isinstance(value, bool):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value
