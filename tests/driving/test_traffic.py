import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.cars import LENGTH
from pipeline.driving.tracks import make_track
from pipeline.driving.traffic import (
    SENSOR_RANGE,
    SPEED_LIMIT,
    TRAFFIC_SPEEDS,
    Begins,
    along_road,
    gap_ahead,
    reaches,
    start,
)
from tests.driving.scenes import cars_at, overlapping, track_names


@given(
    track_names,
    st.integers(0, 2**32 - 1),
    st.integers(0, 40),
    st.floats(0, 5),
    st.floats(0, 1),
    st.sampled_from(["anywhere", "line"]),
)
def test_no_car_starts_inside_another(
    name: str, seed: int, traffic: int, offset: float, angle: float, begins: Begins
) -> None:
    track = make_track(name)
    cars = start(track, traffic, (offset, angle), np.random.default_rng(seed), begins=begins)
    assert len(cars) == traffic + 1
    assert not overlapping(cars)
    assert np.all(np.abs(cars.d) <= track.half_width)
    assert np.all(cars.speed == cars.limit) and cars.limit[0] == SPEED_LIMIT
    assert np.all((cars.limit[1:] >= TRAFFIC_SPEEDS[0]) & (cars.limit[1:] <= TRAFFIC_SPEEDS[1]))


@given(track_names, st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_on_the_start_line_is_our_car_and_no_other(name: str, seed: int, traffic: int) -> None:
    track = make_track(name)
    anywhere, line = (
        start(track, traffic, (0.3, 0.05), np.random.default_rng(seed), begins=begins)
        for begins in ("anywhere", "line")
    )
    assert line.s[0] == 0.0 and np.all(line.s[1:] % track.length > 0)
    assert line.d[0] == anywhere.d[0]  # the same lane


@pytest.mark.parametrize("name", ["willow", "alder"])
@pytest.mark.parametrize("traffic", [-1, 1000])
def test_a_track_fills_up_to_what_it_says_of_more(name: str, traffic: int) -> None:
    track, rng = make_track(name), np.random.default_rng(0)
    with pytest.raises(ValueError) as error:
        start(track, traffic, (0.0, 0.0), rng)
    told = re.fullmatch(rf"traffic is {traffic}, .* 0 to (\d+) .* {name}", str(error.value))
    assert len(start(track, int(told[1]), (0.0, 0.0), rng)) == int(told[1]) + 1


def test_distances_along_the_road_wrap_at_the_start_line() -> None:
    track = make_track("alder")
    cars = cars_at(track, [5.0, track.length - 5.0, 3 * track.length + 25.0], [0, 0, 1])
    along = along_road(cars, track)
    np.testing.assert_allclose(along[0, 1:], [-10.0, 20.0])
    np.testing.assert_allclose(along[1, [0, 2]], [10.0, 30.0])
    assert np.all(np.isinf(np.diag(along)))


def test_the_gap_ahead_is_bumper_to_bumper_within_the_sensors_range() -> None:
    along = np.array([[np.inf, 30.0, 12.0], [-30.0, np.inf, -18.0], [-12.0, 2.0, np.inf]])
    everyone = np.ones((3, 3), bool)
    np.testing.assert_allclose(gap_ahead(along, everyone), [12.0 - LENGTH, SENSOR_RANGE, 0.0])
    second_only = np.array([[False, True, False]] * 3)
    np.testing.assert_allclose(gap_ahead(along, second_only)[0], 30.0 - LENGTH)


def test_a_car_on_the_line_reaches_into_both_lanes() -> None:
    track = make_track("willow")
    on_the_line, in_the_left = np.array([0.0]), track.lane_centres[:1]
    assert reaches(on_the_line, track.lane_centres).tolist() == [[True], [True]]
    assert reaches(in_the_left, track.lane_centres).tolist() == [[True], [False]]
