"""Reading a run's metrics: what is missing or wrong is named in one line."""

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.evaluation.outcomes import write_outcomes
from pipeline.evaluation.results import read_results
from pipeline.policies.strategies import Strategy
from tests.evaluation.sample import drives, write_run


def test_rollouts_belong_to_the_policies_that_drove_them(tmp_path: Path) -> None:
    results = read_results(write_run(tmp_path), 3)
    recalls = [step.next_rollout and step.next_rollout.recall for step in results.iterations]
    assert recalls == [pytest.approx(0.48), pytest.approx(0.46), pytest.approx(0.44), None]
    assert results.first.number == 0
    assert results.last.number == 3
    assert [step.number for step in results.loop] == [1, 2, 3]
    naive = results.last.driving[Strategy.NAIVE]
    assert naive["traffic"].laps == pytest.approx((2.8 + 3 + 3) / 3, rel=1e-5)
    assert results.d_safe.queries == 1201


def test_fewer_iterations_can_be_read(tmp_path: Path) -> None:
    assert len(read_results(write_run(tmp_path), 1).iterations) == 2
    with pytest.raises(ValueError, match="iterations 0: expected at least 1"):
        read_results(tmp_path, 0)


@pytest.mark.parametrize(
    "name",
    [
        "driving_safedagger_1.json",
        "drives_0.csv",
        "ledger_D_safe.json",
        "safety_safedagger_3.json",
        "rollout_safedagger_2.json",
    ],
)
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    (write_run(tmp_path) / name).unlink()
    with pytest.raises(FileNotFoundError, match=f"{name}: no such file, expected"):
        read_results(tmp_path, 3)


@pytest.mark.parametrize(
    ("name", "keys", "value", "problem"),
    [
        ("ledger_D_safedagger_1.json", ("queries",), None, "queries is null, expected a number"),
        ("ledger_D_safedagger_1.json", ("queries",), "9", 'queries is "9", expected a number'),
        ("safety_0.json", ("held_out",), {}, "held_out.auroc is nothing, expected a number"),
        (
            "rollout_safedagger_1.json",
            ("rollout",),
            3,
            "rollout.auroc is nothing, expected a number",
        ),
        (
            "driving_safedagger_2.json",
            ("naive", "traffic", "laps"),
            True,
            "naive.traffic.laps is true, expected a number",
        ),
        (
            "driving_safedagger_2.json",
            ("safe",),
            {},
            "safe.no_traffic.laps is nothing, expected a number",
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
    with pytest.raises(ValueError) as error:
        read_results(tmp_path, 3)
    assert str(error.value) == f"{path}: {problem}"


@pytest.mark.parametrize("content", ["", "{", '{"tau": NaN}', "[]"])
def test_a_file_that_is_no_json_object(tmp_path: Path, content: str) -> None:
    path = write_run(tmp_path) / "safety_0.json"
    path.write_text(content)
    with pytest.raises(ValueError, match="expected") as error:
        read_results(tmp_path, 3)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_case_without_drives_is_named(tmp_path: Path) -> None:
    path = write_run(tmp_path) / "drives_safedagger_2.csv"
    write_outcomes(path, [d for d in drives(2) if d.traffic == 0 or d.track != "yew"])
    with pytest.raises(
        ValueError, match=r"drives_safedagger_2.csv: no drive of naive, traffic, yew"
    ):
        read_results(tmp_path, 3)
