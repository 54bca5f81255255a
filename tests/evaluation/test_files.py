"""Reading JSON: what is missing or wrong is named in one line."""

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.evaluation.files import ErrorShares, Ledger, Quality, Rows, read_json
from tests.evaluation.written import quality, write_run


def changed(path: Path, *lost: str, **values: Any) -> Path:
    """With a first row that lacks some of its values, and has others."""
    content = json.loads(path.read_text())
    row = content["rows"][0] | values
    content["rows"][0] = {name: value for name, value in row.items() if name not in lost}
    path.write_text(json.dumps(content))
    return path


def test_rows_are_read_and_the_rest_left_alone(tmp_path: Path) -> None:
    path = changed(write_run(tmp_path) / "safety_0.json", recall=None, more=3)
    (found,) = read_json(path, Rows[Quality]).rows
    assert (found.tau, found.auroc, found.recall) == (0.0025, 0.9, None)
    assert found.calibration == quality(0.9)["calibration"]


def test_what_older_metrics_lack_is_none(tmp_path: Path) -> None:
    lost = ("average_precision", "calibration_error", "calibration")
    path = changed(write_run(tmp_path) / "safety_0.json", *lost)
    (found,) = read_json(path, Rows[Quality]).rows
    assert (found.average_precision, found.calibration_error, found.calibration) == (None, None, [])
    path = changed(write_run(tmp_path) / "ledger_D_0.json", "calls", "failures")
    (ledger,) = read_json(path, Rows[Ledger]).rows
    assert (ledger.calls, ledger.failures) == (None, None)


def test_errors_that_were_judged_without_a_share(tmp_path: Path) -> None:
    path = write_run(tmp_path) / "errors.json"
    content = json.loads(path.read_text())
    assert read_json(path, ErrorShares).held_out.tau_for_share == 0.0018
    del content["share"], content["held_out"]["tau_for_share"]
    path.write_text(json.dumps(content))
    found = read_json(path, ErrorShares)
    assert (found.share, found.held_out.tau_for_share) == (None, None)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none.json: no such file, expected JSON"):
        read_json(tmp_path / "none.json", dict)


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"queries": None}, "Input should be a valid integer"),
        ({"queries": "9"}, "Input should be a valid integer"),
        ({"queries": True}, "Input should be a valid integer"),
        ({}, "Field required"),
    ],
)
def test_a_wrong_value_is_named(tmp_path: Path, values: dict[str, Any], problem: str) -> None:
    path = write_run(tmp_path) / "ledger_D_safedagger_1.json"
    changed(path, *({"queries"} - values.keys()), **values)
    with pytest.raises(ValueError) as error:
        read_json(path, Rows[Ledger])
    assert str(error.value) == f"{path}: rows.0.queries: {problem}"


@pytest.mark.parametrize("content", ["", "{", '{"tau": NaN}', "[]", "{}"])
def test_another_file_is_refused_in_one_line(tmp_path: Path, content: str) -> None:
    path = tmp_path / "safety_0.json"
    path.write_text(content)
    with pytest.raises(ValueError) as error:
        read_json(path, Rows[Quality])
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)
