import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.inspection.canvas import png
from pipeline.inspection.contact_sheet import Shown, contact_sheet, extreme_frames


@pytest.mark.parametrize(
    ("probability", "episode", "most", "least"),
    [
        ([0.9, 0.95, 0.1, np.nan, 0.2, 0.3, 0.8], [0, 0, 0, 0, 1, 1, 2], [1, 6, 5], [2, 4, 6]),
        ([0.5, 0.6, 0.7, 0.1], [0, 0, 0, 1], [2, 3, 1], [3, 0, 1]),
    ],
    ids=["one of each", "more of few"],
)
def test_each_episode_gives_its_most_extreme_frame_before_others_come(
    probability: list[float], episode: list[int], most: list[int], least: list[int]
) -> None:
    found = extreme_frames(np.array(probability), np.array(episode), 3)
    assert [rows.tolist() for rows in found] == [most, least]


@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 4)), min_size=1, max_size=30), st.data())
def test_no_frame_left_out_is_more_extreme_in_its_episode(rows: list, data: st.DataObject) -> None:
    probability, episode = (np.array(column) for column in zip(*rows, strict=True))
    count = data.draw(st.integers(1, len(rows)))
    safest, least_safe = extreme_frames(probability, episode, count)
    for chosen, sign in ((safest, -1), (least_safe, 1)):
        assert len(set(chosen.tolist())) == count
        for row in chosen:
            rivals = np.setdiff1d(np.flatnonzero(episode == episode[row]), chosen)
            assert np.all(sign * probability[rivals] >= sign * probability[row])


def test_frames_without_a_safety_policy_are_refused() -> None:
    with pytest.raises(ValueError, match="1 frames have a safe probability, expected at least 2"):
        extreme_frames(np.array([np.nan, 0.5]), np.array([0, 0]), 2)


def test_a_sheet_shows_every_frame_with_its_probability_and_its_place() -> None:
    rng = np.random.default_rng(0)
    frames = [
        Shown(rng.integers(0, 256, (72, 160, 3), np.uint8), probability, 7, row)
        for row, probability in enumerate((0.999, 0.95, 0.9, 0.85, 0.8, 0.75, 0.1))
    ]
    figure = contact_sheet("rollout_1", frames[:6], frames[6:])
    upper, lower = figure.subfigs
    shown = [axes for axes in (*upper.axes, *lower.axes) if axes.images]
    assert [axes.get_title("center") for axes in shown] == [
        f"{f.safe_probability:.3f}" for f in frames
    ]
    for row, (axes, frame) in enumerate(zip(shown, frames, strict=True)):
        np.testing.assert_array_equal(axes.images[0].get_array(), frame.image)
        assert [text.get_text() for text in axes.texts] == [f"episode 7, frame {row}"]
    assert png(figure) == png(contact_sheet("rollout_1", frames[:6], frames[6:]))


def test_a_sheet_needs_both() -> None:
    image = np.zeros((72, 160, 3), np.uint8)
    with pytest.raises(ValueError, match="expected some safe and some unsafe"):
        contact_sheet("rollout_1", [Shown(image, 0.9, 0, 0)], [])
