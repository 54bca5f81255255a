from dataclasses import fields
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.driving.tracks import LANE_WIDTH, PROPS, TEST, TRAINING, Look, make_track
from tests.driving.scenes import NAMES, track_names


def test_seven_tracks_to_train_on_and_three_to_test() -> None:
    assert len(TRAINING) == 7 and len(TEST) == 3 and not set(TRAINING) & set(TEST)


@pytest.mark.parametrize(("one", "other"), list(combinations(NAMES, 2)))
def test_no_two_tracks_are_alike(one: str, other: str) -> None:
    a, b = make_track(one), make_track(other)
    assert a.look != b.look
    assert a.length != b.length
    bends = np.sort(np.abs(a.centreline.curvature)), np.sort(np.abs(b.centreline.curvature))
    assert np.max(np.abs(bends[0] - bends[1])) > 1e-3


def test_training_and_test_each_have_two_to_four_lanes_and_both_hands() -> None:
    for names in (TRAINING, TEST):
        assert {make_track(name).lanes for name in names} == {2, 3, 4}
        assert {make_track(name).centreline.curvature.mean() > 0 for name in names} == {True, False}


def within_training(look: Look) -> bool:
    """Whether every property was seen in training, be it on different tracks."""
    seen = [design.look for design in TRAINING.values()]
    for field in fields(Look):
        values = [getattr(other, field.name) for other in seen]
        value = getattr(look, field.name)
        if field.name in ("asphalt", "grain"):
            if not min(values) <= value <= max(values):
                return False
        elif value not in values:
            return False
    return True


@given(track_names)
def test_every_look_lies_within_what_training_shows(name: str) -> None:
    assert within_training(make_track(name).look)


@given(st.integers(0, 10_000))
def test_a_random_track_is_determined_by_its_seed(seed: int) -> None:
    one = make_track(f"random:{seed}")
    make_track.cache_clear()
    again, other = make_track(f"random:{seed}"), make_track(f"random:{seed + 1}")
    np.testing.assert_array_equal(one.centreline.x, again.centreline.x)
    assert (one.lanes, one.look, one.length) == (again.lanes, again.look, again.length)
    assert one.length != other.length
    assert 2 <= one.lanes <= 4 and one.look.props in PROPS


@pytest.mark.parametrize(
    "name", ["", "oak", "Alder", "random:", "random:-1", "random:x", "random:1.5", "random"]
)
def test_an_unknown_track_is_refused_in_one_line(name: str) -> None:
    with pytest.raises(ValueError) as error:
        make_track(name)
    message = str(error.value)
    assert repr(name) in message and "alder" in message and "random:<seed>" in message
    assert "\n" not in message


@given(track_names, st.data())
def test_the_lane_of_a_place_is_the_one_whose_middle_is_nearest(
    name: str, data: st.DataObject
) -> None:
    track = make_track(name)
    np.testing.assert_array_equal(track.lane_of(track.lane_centres), np.arange(track.lanes))
    np.testing.assert_allclose(np.diff(track.lane_centres), -LANE_WIDTH)
    assert track.lane_centres.sum() == pytest.approx(0)
    lines = np.array([track.edge_lines[0], *track.lane_lines, track.edge_lines[1]])
    np.testing.assert_allclose((lines[1:] + lines[:-1]) / 2, track.lane_centres[::-1], atol=1e-9)
    d = data.draw(st.floats(-track.half_width, track.half_width))
    nearest = np.min(np.abs(track.lane_centres - d))
    found = track.lane_centres[track.lane_of(np.array([d]))[0]]
    assert abs(found - d) == pytest.approx(nearest)
