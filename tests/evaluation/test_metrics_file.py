"""Reading metrics: what is missing or wrong is named in one line."""

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.data.ledger import Ledger
from pipeline.evaluation.metrics_file import MetricsFile, SafetyQuality
from tests.evaluation.sample import write_run


def test_records_are_read_and_the_rest_left_alone(tmp_path: Path) -> None:
    path = write_run(tmp_path) / "safety_0.json"
    content = json.loads(path.read_text())
    content["held_out"] |= {"recall": None, "frames": 1120.0}
    path.write_text(json.dumps(content))
    file = MetricsFile(path)
    assert file.number("tau") == 0.0025
    found = file.record(SafetyQuality, "held_out")
    assert (found.auroc, found.recall) == (0.9, None)


def test_what_is_there_can_be_asked(tmp_path: Path) -> None:
    path = tmp_path / "metrics.json"
    path.write_text('{"held_out": {"share": null}}')
    file = MetricsFile(path)
    assert file.has("held_out") and file.has("held_out", "share")
    assert not file.has("share") and not file.has("held_out", "share", "tau")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none.json: no such file, expected"):
        MetricsFile(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("name", "keys", "value", "problem"),
    [
        ("ledger_D_safedagger_1.json", ("queries",), None, "queries is null, expected a number"),
        ("ledger_D_safedagger_1.json", ("queries",), "9", 'queries is "9", expected a number'),
        ("ledger_D_safedagger_1.json", ("queries",), True, "queries is true, expected a number"),
        ("safety_0.json", ("held_out",), {}, "held_out.auroc is nothing, expected a number"),
        (
            "rollout_safedagger_1.json",
            ("rollout",),
            3,
            "rollout.auroc is nothing, expected a number",
        ),
    ],
)
def test_a_wrong_value_is_named(
    tmp_path: Path, name: str, keys: tuple[str, ...], value: Any, problem: str
) -> None:
    path = write_run(tmp_path) / name
    content = json.loads(path.read_text())
    inner = content
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = value
    path.write_text(json.dumps(content))
    of = {"ledger": (Ledger,), "safety": (SafetyQuality, "held_out")}
    kind, *where = of.get(name.split("_")[0], (SafetyQuality, "rollout"))
    with pytest.raises(ValueError) as error:
        MetricsFile(path).record(kind, *where)
    assert str(error.value) == f"{path}: {problem}"


@pytest.mark.parametrize("content", ["", "{", '{"tau": NaN}', "[]"])
def test_a_file_that_is_no_json_object(tmp_path: Path, content: str) -> None:
    path = write_run(tmp_path) / "safety_0.json"
    path.write_text(content)
    with pytest.raises(ValueError, match="expected") as error:
        MetricsFile(path).number("tau")
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_all_numbers_of_an_object(tmp_path: Path) -> None:
    path = tmp_path / "driving_0.json"
    path.write_text('{"naive": {"traffic": {"laps": 2.5, "takeover_length": null}}, "tau": 1}')
    file = MetricsFile(path)
    assert file.numbers("naive", "traffic") == {"laps": 2.5, "takeover_length": None}
    for keys in (("safe",), ("tau",)):
        with pytest.raises(ValueError, match=f"^{path}: {keys[0]} is no object, expected numbers$"):
            file.numbers(*keys)


@pytest.mark.parametrize(("content", "found"), [("{}", "nothing"), ('{"tracks": 3}', "3")])
def test_text_is_text(content: str, found: str, tmp_path: Path) -> None:
    path = tmp_path / "driving_0.json"
    path.write_text('{"tracks": "yew,random:9"}')
    assert MetricsFile(path).text("tracks") == "yew,random:9"
    path.write_text(content)
    with pytest.raises(ValueError, match=f"^{path}: tracks is {found}, expected text$"):
        MetricsFile(path).text("tracks")
