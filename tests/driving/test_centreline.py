import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.centreline import AGAINST, CLEARANCE, LENGTHS, random_centreline
from pipeline.driving.tracks import TIGHTEST, make_track
from tests.driving.scenes import NAMES, track_names


@given(track_names, st.floats(-700, 1400), st.floats(-1, 1), st.floats(-1, 1))
def test_local_coordinates_are_the_inverse_of_position(
    name: str, s: float, side: float, off: float
) -> None:
    track = make_track(name)
    where = np.array([s]), np.array([side * track.half_width])
    x, y = track.centreline.position(*where)
    found = track.centreline.local_coordinates(x, y, where[0] + off)
    np.testing.assert_allclose(found, where, atol=0.02)


@given(track_names)
def test_a_track_is_a_smooth_closed_loop_that_turns_once(name: str) -> None:
    line = make_track(name).centreline
    step = line.length / len(line.x)
    total = np.sum(line.curvature) * step
    assert abs(total) == pytest.approx(2 * np.pi, rel=1e-6)
    apart = np.hypot(np.diff(line.x, append=line.x[0]), np.diff(line.y, append=line.y[0]))
    np.testing.assert_allclose(apart, step, rtol=0.02)
    ends = line.position(np.array([0.0, line.length]), np.zeros(2))
    np.testing.assert_allclose(np.ptp(ends, axis=1), 0, atol=1e-9)


@given(track_names)
def test_heading_is_the_direction_of_travel(name: str) -> None:
    line = make_track(name).centreline
    travel = np.arctan2(np.diff(line.y), np.diff(line.x))
    bend = np.abs(np.exp(1j * travel) - np.exp(1j * line.heading[:-1]))
    assert bend.max() < 0.02
    np.testing.assert_allclose(
        np.diff(line.heading),
        line.curvature[1:] * line.length / len(line.x),
        atol=1e-3,
    )


@given(track_names)
def test_left_of_the_road_is_positive(name: str) -> None:
    line = make_track(name).centreline
    s = np.linspace(0, line.length, 50)
    x, y = line.position(s, np.zeros(50))
    left_x, left_y = line.position(s, np.ones(50))
    heading = line.heading_at(s)
    cross = np.cos(heading) * (left_y - y) - np.sin(heading) * (left_x - x)
    np.testing.assert_allclose(cross, 1.0, atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.floats(*TIGHTEST), st.booleans())
def test_the_tightest_bend_is_what_was_asked(seed: int, tightest: float, clockwise: bool) -> None:
    line = random_centreline(np.random.default_rng(seed), tightest, clockwise)
    assert 1 / np.max(np.abs(line.curvature)) == pytest.approx(tightest)
    assert LENGTHS[0] <= line.length <= LENGTHS[1]


@pytest.mark.parametrize("name", NAMES)
def test_bends_go_both_ways(name: str) -> None:
    curvature = make_track(name).centreline.curvature
    left = np.mean(curvature > 0)
    assert AGAINST <= left <= 1 - AGAINST


@pytest.mark.parametrize("name", NAMES)
def test_no_stretch_of_road_comes_near_another(name: str) -> None:
    track = make_track(name)
    s = np.linspace(0, track.length, 300, endpoint=False)
    x, y = track.centreline.position(s, np.zeros(300))
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    along = np.abs(s[:, None] - s)
    far = np.minimum(along, track.length - along) > 2 * CLEARANCE
    assert apart[far].min() > 2 * track.half_width + 10
