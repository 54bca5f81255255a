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


FAR = LENGTH + SENSOR_RANGE


@pytest.mark.parametrize(
    ("s", "others", "lanes", "gaps"),
    [
        pytest.param(50, [], [1], [None, None, None], id="an empty road"),
        pytest.param(
            *(50, [20, 40, 30, 50, 12, -5], [1, 0, 0, 1, 1, 2, 1], [20, 30, 12]),
            id="the nearest in front of each lane",
        ),
        pytest.param(
            *(50, [FAR, -10, 10], [0, 0, 0, 2], [None, None, None]),
            id="beyond the range, behind, or in no lane beside ours",
        ),
        pytest.param(-10, [25], [1, 1], [None, 25, None], id="across the start line"),
        pytest.param(50, [1], [1, 0], [LENGTH, None, None], id="beside, at distance zero"),
    ],
)
def test_cars_ahead_to_the_left_in_our_lane_and_to_the_right(
    alder: Track, s: float, others: list[float], lanes: list[int], gaps: list[float | None]
) -> None:
    """The others are so far ahead of ours, which is the first; gaps are from middle to middle."""
    places = np.remainder([s, *(s + ahead for ahead in others)], alder.length)
    seen = named(cars_at(alder, places.tolist(), lanes), alder)
    for side, gap in zip(("left", "ahead", "right"), gaps, strict=True):
        assert seen[f"car_{side}"] == (gap is not None)
        expected = SENSOR_RANGE if gap is None else gap - LENGTH
        assert seen[f"distance_{side}"] == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    ("offset", "angle", "position", "turned"),
    [
        (0.0, 0.0, 0.0, 0.0),
        (0.9, FULL_ANGLE / 2, 0.5, 0.5),
        (-0.9, -FULL_ANGLE / 5, -0.5, -0.2),
        (1.7, 1.2, 1.7 / 1.8, 1.0),
        (-4.0, -1.2, -1.0, -1.0),
    ],
)
def test_the_position_in_the_lane_and_the_angle_to_it(
    alder: Track, offset: float, angle: float, position: float, turned: float
) -> None:
    lane = 2  # the rightmost: beyond its right line there is no other
    seen = named(cars_at(alder, [50.0], [lane], offset=offset, angle=angle), alder)
    assert (seen["lane_position"], seen["lane_angle"]) == pytest.approx(
        (position, turned), abs=1e-5
    )


def test_the_position_jumps_from_line_to_line(alder: Track) -> None:
    left = LANE_WIDTH / 2
    before = named(cars_at(alder, [50.0], [1], offset=left - 0.01), alder)["lane_position"]
    after = named(cars_at(alder, [50.0], [1], offset=left + 0.01), alder)["lane_position"]
    assert before > 0.99 and after < -0.99


@given(track_names, st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_units_and_ranges(name: str, seed: int, traffic: int) -> None:
    track = make_track(name)
    values = affordances(start(track, traffic, (2.0, 0.5), np.random.default_rng(seed)), track)
    assert values.dtype == np.float32 and values.shape == (len(AFFORDANCES),)
    assert set(values[:5]) <= {0.0, 1.0}
    assert np.all((values[5:8] >= 0) & (values[5:8] <= SENSOR_RANGE))
    assert np.all(np.abs(values[8:]) <= 1)
    np.testing.assert_array_equal(values[2:5] == 1, values[5:8] < SENSOR_RANGE)
