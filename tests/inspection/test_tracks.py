"""Track sheets: a top view and a sample frame for every track."""

import numpy as np
import pytest

from pipeline.driving.tracks import TEST, TRAINING, make_track
from pipeline.inspection.canvas import png
from pipeline.inspection.tracks import sample_frame, track_sheet


@pytest.mark.parametrize("names", [["yew"], list(TEST), [*list(TRAINING)[:4], "random:3"]])
def test_every_track_has_its_two_panels(names: list[str]) -> None:
    figure = track_sheet(names, "Tracks")
    assert len(figure.axes) == 2 * len(names)
    maps, frames = figure.axes[::2], figure.axes[1::2]
    assert [axes.get_title(loc="left") for axes in maps] == names
    for name, axes in zip(names, maps, strict=True):
        line = make_track(name).centreline
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        assert left < line.x.min() and line.x.max() < right
        assert bottom < line.y.min() and line.y.max() < top
    for axes in frames:
        (image,) = axes.get_images()
        assert image.get_array().shape == (72, 160, 3)
        assert np.std(image.get_array()) > 10


def test_the_sample_frame_has_a_car_ahead() -> None:
    first, cars = sample_frame(make_track("yew"))
    second, _ = sample_frame(make_track("yew"))
    assert np.array_equal(first, second)
    apart = np.hypot(cars.x[1:] - cars.x[0], cars.y[1:] - cars.y[0])
    assert apart.min() < 40


def test_equal_bytes_or_one_line() -> None:
    assert png(track_sheet(["willow"], "Tracks")) == png(track_sheet(["willow"], "Tracks"))
    for names, problem in ((["nowhere"], "track 'nowhere'"), ([], "no tracks")):
        with pytest.raises(ValueError, match=problem):
            track_sheet(names, "Tracks")
