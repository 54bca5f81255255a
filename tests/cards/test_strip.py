"""Sample frames: evenly spaced, and the dataset's own."""

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cards.strip import sample_rows, strip
from pipeline.driving.tracks import make_track
from pipeline.inspection.tracks import sample_frame


@given(st.integers(1, 100_000), st.integers(1, 12))
def test_rows_are_evenly_spaced(frames: int, count: int) -> None:
    rows = sample_rows(frames, count)
    assert len(rows) == min(frames, count)
    assert rows[0] >= 0 and rows[-1] < frames
    steps = np.diff([*rows])
    assert len(rows) == 1 or (steps.min() >= 1 and np.ptp(steps) <= 1)


def test_a_strip_is_small_and_shows_the_images_beside_each_other() -> None:
    images = [sample_frame(make_track(name))[0] for name in ("spruce", "willow", "yew") * 2]
    picture = strip(images)
    assert len(picture) < 30_000
    shown = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert shown.shape == (72, 6 * 160 + 5 * 2, 3)
    for number, image in enumerate(images):
        difference = shown[:, 162 * number :][:, :160].astype(int) - image
        assert np.abs(difference).mean() < 5
