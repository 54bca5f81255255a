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
from tests.evaluation.sample import drives, outcome, quality


def measured(*rows: dict[str, Any]) -> dict[str, Any]:
    return measure(table(rows), METRICS)


def test_laps_are_the_mean_over_the_drives() -> None:
    assert measured(outcome(laps=1.0), outcome(laps=2.5, start=1))["laps"] == 1.75


def test_damage_is_per_distance_driven_and_pooled() -> None:
    pooled = measured(outcome(laps=0.5, damage=6.0), outcome(laps=2.5, damage=0.0))
    assert pooled["damage_per_lap"] == 2.0
    assert measured(outcome(laps=0.0, damage=6.0))["damage_per_lap"] is None


def test_the_steering_error_is_per_frame_of_the_primary() -> None:
    long = outcome(frames=300, primary_frames=300, deviation_sum=3.0)
    short = outcome(frames=300, takeover_frames=200, primary_frames=100, deviation_sum=5.0)
    pooled = measured(long, short)
    assert pooled["steering_mse"] == 8.0 / 400
    assert pooled["takeover"] == 200 / 600
    reference = outcome(takeover_frames=500, primary_frames=0, deviation_sum=0.0)
    assert measured(reference)["steering_mse"] is None
    assert measured(reference)["takeover"] == 1.0


def test_where_nobody_can_be_looked_up_nothing_is_measured() -> None:
    unknown = measured(outcome(deviation_sum=math.nan))
    assert unknown["steering_mse"] is None
    assert unknown["takeover"] == 0.0


def test_off_road_is_a_share_of_the_drives() -> None:
    left = measured(*(outcome(off_road=off_road) for off_road in (1.0, 0.0, 0.0, 1.0)))
    assert left["off_road"] == 0.5


def test_a_success_is_a_drive_to_its_end_without_a_touch() -> None:
    done = {"ended": "laps done", "off_road": 0.0}
    ends = (done, done | {"touches": 2.0}, {"ended": "out of time", "off_road": 0.0}, {})
    assert measured(*(outcome(**end) for end in ends))["success"] == 0.25


def test_failures_are_all_that_went_wrong_on_the_way() -> None:
    """The road left, a standstill, two touches: four in 20 km, however far backwards."""
    stood = {"ended": "stood still", "off_road": 0.0, "distance_m": -1000.0}
    far = {"ended": "laps done", "off_road": 0.0, "distance_m": 18_100.0, "touches": 2.0}
    pooled = measured(*(outcome(**end) for end in ({}, stood, far)))
    assert pooled["failures"] == pytest.approx(20.0)


def test_takeovers_have_a_mean_length_and_drivers_change_so_often_a_lap() -> None:
    one = outcome(laps=1.0, takeover_frames=30, primary_frames=470, takeovers=3, switches=6)
    other = outcome(laps=2.0, takeover_frames=20, primary_frames=480, takeovers=2, switches=3)
    pooled = measured(one, other)
    assert (pooled["takeover_length"], pooled["switches_per_lap"]) == (10.0, 3.0)
    assert measured(outcome())["takeover_length"] is None


errors = st.floats(0, 4)


@given(st.lists(st.tuples(errors, st.integers(1, 1000)), min_size=1, max_size=8))
def test_pooled_error_is_between_least_and_largest(parts: list[tuple[float, int]]) -> None:
    rows = (outcome(frames=n, primary_frames=n, deviation_sum=mse * n) for mse, n in parts)
    pooled = measured(*rows)["steering_mse"]
    lowest, highest = min(mse for mse, _ in parts), max(mse for mse, _ in parts)
    assert lowest * (1 - 1e-12) <= pooled <= highest * (1 + 1e-12)


@given(st.integers(0, 2**32 - 1))
def test_the_order_of_the_drives_does_not_matter(seed: int) -> None:
    shuffled = drives(1).sample(frac=1, random_state=seed)
    assert measure(shuffled, METRICS) == measure(drives(1), METRICS)


def test_dvc_shows_few_numbers_of_each_policy(tmp_path: Path) -> None:
    found = headline(drives(1), METRICS)
    assert {name: set(metrics) for name, metrics in found.items()} == {
        "naive": {"laps", "success", "failures"},
        "safe": {"laps", "takeover"},
    }
    safe = measure(among(drives(1), strategy="safe"), METRICS)
    assert found["safe"]["laps"] == safe["laps"]
    alone = headline(among(drives(1), strategy="naive"), METRICS)
    assert set(alone) == {"naive"}


def test_of_a_row_dvc_shows_what_its_metrics_say(tmp_path: Path) -> None:
    """It takes numbers and text for metrics, and no lists."""
    write_rows(tmp_path / "safety_0.json", quality(0.9), QUALITY)
    written = json.loads((tmp_path / "safety_0.json").read_text())
    (row,), expected = written.pop("rows"), quality(0.9)
    assert row.pop("reliability") == expected.pop("reliability")
    assert row == pytest.approx(expected)
    assert written == pytest.approx({"auroc": 0.9, "recall": 0.6})


def test_no_drives_no_metrics() -> None:
    with pytest.raises(ValueError, match="no drives, expected at least one"):
        measure(drives(1)[:0], METRICS)


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
