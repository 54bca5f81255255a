import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.affordances import FULL_ANGLE, affordances
from pipeline.driving.cars import LENGTH, Cars
from pipeline.driving.features import AFFORDANCES, SENSOR_RANGE
from pipeline.driving.tracks import LANE_WIDTH, Track, make_track
from pipeline.driving.traffic import start
from tests.driving.scenes import cars_at, track_names


def named(cars: Cars, track: Track) -> dict[str, float]:
    return dict(zip(AFFORDANCES, affordances(cars, track).tolist(), strict=True))


@pytest.mark.parametrize(("lane", "left", "right"), [(0, 0, 1), (1, 1, 1), (2, 1, 0)])
def test_lanes_beside(alder: Track, lane: int, left: int, right: int) -> None:
    seen = named(cars_at(alder, [50.0], [lane]), alder)
    assert (seen["lane_left"], seen["lane_right"]) == (left, right)


def test_an_empty_road_reads_the_sensors_range(alder: Track) -> None:
    seen = named(cars_at(alder, [50.0], [1]), alder)
    for side in ("left", "ahead", "right"):
        assert seen[f"car_{side}"] == 0 and seen[f"distance_{side}"] == SENSOR_RANGE


def test_the_nearest_car_in_front_of_each_lane_counts(alder: Track) -> None:
    s = [50.0, 70.0, 90.0, 80.0, 100.0, 62.0, 45.0]
    seen = named(cars_at(alder, s, [1, 0, 0, 1, 1, 2, 1]), alder)
    assert (seen["car_left"], seen["car_ahead"], seen["car_right"]) == (1, 1, 1)
    assert seen["distance_left"] == pytest.approx(20 - LENGTH, abs=1e-4)
    assert seen["distance_ahead"] == pytest.approx(30 - LENGTH, abs=1e-4)
    assert seen["distance_right"] == pytest.approx(12 - LENGTH, abs=1e-4)


def test_cars_beyond_the_range_behind_or_in_no_lane_of_ours_do_not_count(alder: Track) -> None:
    far = 50.0 + LENGTH + SENSOR_RANGE
    seen = named(cars_at(alder, [50.0, far, 40.0, 60.0], [0, 0, 0, 2]), alder)
    for side in ("left", "ahead", "right"):
        assert seen[f"car_{side}"] == 0 and seen[f"distance_{side}"] == SENSOR_RANGE


def test_a_car_across_the_start_line_counts(alder: Track) -> None:
    seen = named(cars_at(alder, [alder.length - 10.0, 15.0], [1, 1]), alder)
    assert seen["distance_ahead"] == pytest.approx(25 - LENGTH, abs=1e-4)


def test_a_car_beside_is_at_distance_zero(alder: Track) -> None:
    seen = named(cars_at(alder, [50.0, 51.0], [1, 0]), alder)
    assert (seen["car_left"], seen["distance_left"]) == (1, 0)


@pytest.mark.parametrize(
    ("offset", "reads"), [(0.0, 0.0), (0.9, 0.5), (-0.9, -0.5), (1.7, 1.7 / 1.8), (-4.0, -1.0)]
)
def test_the_position_in_the_lane(alder: Track, offset: float, reads: float) -> None:
    lane = 2  # the rightmost: beyond its right line there is no other
    seen = named(cars_at(alder, [50.0], [lane], offset=offset), alder)
    assert seen["lane_position"] == pytest.approx(reads, abs=1e-5)


def test_the_position_jumps_from_line_to_line(alder: Track) -> None:
    left = LANE_WIDTH / 2
    before = named(cars_at(alder, [50.0], [1], offset=left - 0.01), alder)["lane_position"]
    after = named(cars_at(alder, [50.0], [1], offset=left + 0.01), alder)["lane_position"]
    assert before > 0.99 and after < -0.99


@pytest.mark.parametrize(
    ("angle", "reads"),
    [(0.0, 0.0), (FULL_ANGLE / 2, 0.5), (-FULL_ANGLE / 5, -0.2), (1.2, 1.0), (-1.2, -1.0)],
)
def test_the_angle_to_the_lane(alder: Track, angle: float, reads: float) -> None:
    seen = named(cars_at(alder, [50.0], [1], angle=angle), alder)
    assert seen["lane_angle"] == pytest.approx(reads, abs=1e-5)


@given(track_names, st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_units_and_ranges(name: str, seed: int, traffic: int) -> None:
    track = make_track(name)
    values = affordances(start(track, traffic, (2.0, 0.5), np.random.default_rng(seed)), track)
    assert values.dtype == np.float32 and values.shape == (len(AFFORDANCES),)
    assert set(values[:5]) <= {0.0, 1.0}
    assert np.all((values[5:8] >= 0) & (values[5:8] <= SENSOR_RANGE))
    assert np.all(np.abs(values[8:]) <= 1)
    np.testing.assert_array_equal(values[2:5] == 1, values[5:8] < SENSOR_RANGE)
