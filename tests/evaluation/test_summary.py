"""Known drives give known metrics, as strict JSON."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among, table
from pipeline.evaluation.summary import headline, measure
from pipeline.evaluation.writing import write_metrics, write_rows
from pipeline.metric import QUALITY
from tests.evaluation.made_up import SLOW, drives, outcome
from tests.evaluation.written import quality

DRIVES = drives(SLOW[1], starts=2)


def measured(*rows: dict[str, Any]) -> dict[str, Any]:
    return measure(table(rows), METRICS)


DONE, LATE = ({"ended": end, "off_road": 0.0} for end in ("laps done", "out of time"))
STOOD = {"ended": "stood still", "off_road": 0.0, "distance_m": -1000.0}
HALF = {"frames": 300, "takeover_frames": 200, "primary_frames": 100, "deviation_sum": 5.0}
WHOLE = {"frames": 300, "primary_frames": 300, "deviation_sum": 3.0}
REFERENCE = {"takeover_frames": 500, "primary_frames": 0, "deviation_sum": 0.0}
ONE = {"laps": 1.0, "takeover_frames": 30, "primary_frames": 470, "takeovers": 3, "switches": 6}
TWO = {"laps": 2.0, "takeover_frames": 20, "primary_frames": 480, "takeovers": 2, "switches": 3}


@pytest.mark.parametrize(
    ("drives", "expected"),
    [
        pytest.param([{"laps": 1.0}, {"laps": 2.5}], {"laps": 1.75}, id="a mean over the drives"),
        pytest.param(
            [{"laps": 0.5, "damage": 6.0}, {"laps": 2.5}],
            {"damage_per_lap": 2.0},
            id="damage per distance driven, pooled",
        ),
        pytest.param([{"laps": 0.0, "damage": 6.0}], {"damage_per_lap": None}, id="no distance"),
        pytest.param(
            [WHOLE, HALF],
            {"steering_mse": 8.0 / 400, "takeover": 200 / 600},
            id="errors per frame of the primary",
        ),
        pytest.param(
            [REFERENCE], {"steering_mse": None, "takeover": 1.0}, id="the reference alone"
        ),
        pytest.param(
            [{"deviation_sum": math.nan}],
            {"steering_mse": None, "takeover": 0.0, "takeover_length": None},
            id="nobody can be looked up, and nobody takes over",
        ),
        pytest.param(
            [{}, DONE, DONE, {}], {"off_road": 0.5}, id="off road is a share of the drives"
        ),
        pytest.param(
            [DONE, DONE | {"touches": 2.0}, LATE, {}],
            {"success": 0.25},
            id="a success ends without a touch",
        ),
        pytest.param(  # road left, standstill, two touches: four in 20 km, however far backwards
            [{}, STOOD, DONE | {"distance_m": 18_100.0, "touches": 2.0}],
            {"failures": 20.0},
            id="all that went wrong on the way",
        ),
        pytest.param(
            [ONE, TWO],
            {"takeover_length": 10.0, "switches_per_lap": 3.0},
            id="takeovers have a mean length, and drivers change so often a lap",
        ),
    ],
)
def test_known_drives_give_known_metrics(
    drives: list[dict[str, Any]], expected: dict[str, float | None]
) -> None:
    found = measured(*(outcome(**each) for each in drives))
    assert {name: found[name] for name in expected} == pytest.approx(expected)


@given(st.integers(0, 2**32 - 1))
def test_the_order_of_the_drives_does_not_matter(seed: int) -> None:
    shuffled = DRIVES.sample(frac=1, random_state=seed)
    assert measure(shuffled, METRICS) == measure(DRIVES, METRICS)


def test_dvc_shows_few_numbers_of_each_policy() -> None:
    found = headline(DRIVES, METRICS)
    assert {name: set(metrics) for name, metrics in found.items()} == {
        "naive": {"laps", "success", "failures"},
        "safe": {"laps", "takeover"},
    }
    safe = measure(among(DRIVES, strategy="safe"), METRICS)
    assert found["safe"]["laps"] == safe["laps"]
    alone = headline(among(DRIVES, strategy="naive"), METRICS)
    assert set(alone) == {"naive"}


def test_of_a_row_dvc_shows_what_its_metrics_say(tmp_path: Path) -> None:
    """It takes numbers and text for metrics, and no lists."""
    write_rows(tmp_path / "safety_0.json", quality(0.9), QUALITY)
    written = json.loads((tmp_path / "safety_0.json").read_text())
    (row,), expected = written.pop("rows"), quality(0.9)
    assert row.pop("calibration") == expected.pop("calibration")
    assert row == pytest.approx(expected)
    assert written == pytest.approx({"auroc": 0.9, "recall": 0.6})


def test_no_drives_no_metrics() -> None:
    with pytest.raises(ValueError, match="no drives, expected at least one"):
        measure(DRIVES[:0], METRICS)


def test_metrics_are_strict_json_with_stable_bytes(tmp_path: Path) -> None:
    path = tmp_path / "metrics" / "driving_0.json"
    metrics = {
        "b": np.float32(1 / 3),
        "a": {"nan": float("nan"), "inf": -np.inf, "none": None, "count": np.int64(7)},
        "c": [123456789.0, True],
    }
    write_metrics(path, metrics)
    text = path.read_text()
    assert text.endswith("}\n")
    content = json.loads(text, parse_constant=pytest.fail)
    assert content == {
        "a": {"count": 7, "inf": None, "nan": None, "none": None},
        "b": 0.333333,
        "c": [123457000.0, True],
    }
    assert list(content) == sorted(content)
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_metrics_that_are_no_json_leave_nothing(tmp_path: Path) -> None:
    with pytest.raises(TypeError):
        write_metrics(tmp_path / "metrics.json", {"a": {1, 2}})
    assert not list(tmp_path.iterdir())
