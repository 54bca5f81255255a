"""A drive as a film: every frame, the trail in the driver's colour, and the same bytes again."""

import io

import numpy as np
import pytest
from PIL import Image

from pipeline.driving.tracks import make_track
from pipeline.inspection.film import PRIMARY, REFERENCE, beside, gif, shoot
from pipeline.inspection.tracks import track_map
from pipeline.policies.inference import Driver
from pipeline.rollout.plans import Plan
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from tests.drives import plan

BY_PRIMARY, BY_REFERENCE = (plan(rule, track="yew") for rule in (Naive(), Reference()))


@pytest.mark.parametrize(
    ("plan", "colour", "other"),
    [(BY_PRIMARY, PRIMARY, REFERENCE), (BY_REFERENCE, REFERENCE, PRIMARY)],
)
def test_every_frame_is_shown_and_the_trail_says_who_drove(
    driver: Driver, plan: Plan, colour: tuple, other: tuple
) -> None:
    pictures, tallies = zip(*shoot(plan, driver, "primary_0"), strict=True)
    assert [tally.frames for tally in tallies] == list(range(1, 11))
    laps = [tally.laps for tally in tallies]
    assert np.all(np.diff(laps) > 0) and laps[-1] > 0.02
    trail = [np.all(picture[120:] == colour, axis=2).sum() for picture in pictures]
    assert trail[-1] > trail[0] > 0
    assert not np.any(np.all(pictures[-1][120:] == other, axis=2))


def test_a_film_says_whose_it_is(driver: Driver) -> None:
    (one, _), (other, _) = (next(shoot(BY_PRIMARY, driver, name)) for name in ("pi_0", "pi_3"))
    rows, columns = np.nonzero(np.any(one != other, axis=2))
    assert 0 < rows.max() <= 26 and columns.min() > 240


def test_a_map_says_where_the_road_is() -> None:
    track = make_track("willow")
    picture, to_pixels = track_map("willow", 400)
    assert picture.shape[1] == 400
    s = np.linspace(20, track.length - 20, 50)  # without the start line
    for d, colour in ((1.5, (track.look.asphalt,) * 3), (track.half_width + 8, track.look.ground)):
        columns, rows = to_pixels(*track.centreline.position(s, np.full(50, d))).astype(int).T
        near = np.abs(picture[rows, columns].astype(int) - colour).max(axis=1) < 12
        assert near.mean() > 0.8


def test_a_gif_has_every_picture_and_equal_bytes(driver: Driver) -> None:
    pictures = [picture for picture, _ in shoot(BY_REFERENCE, driver, "primary_0")]
    content = gif(pictures, 100)
    assert gif(pictures, 100) == content
    film = Image.open(io.BytesIO(content))
    assert (film.n_frames, film.size, film.info["duration"]) == (10, pictures[0].shape[1::-1], 100)
    film.seek(9)
    shown = np.asarray(film.convert("RGB")).astype(int)
    assert np.abs(shown - pictures[9]).mean() < 8


def test_the_shorter_of_two_films_waits_at_its_end(driver: Driver) -> None:
    film = [picture for picture, _ in shoot(BY_PRIMARY, driver, "primary_0")]
    both = beside(film, film[:4])
    width = film[0].shape[1]
    assert len(both) == len(film)
    for number, picture in enumerate(both):
        np.testing.assert_array_equal(picture[:, :width], film[number])
        np.testing.assert_array_equal(picture[:, width:], film[min(number, 3)])


def test_no_pictures_are_refused() -> None:
    with pytest.raises(ValueError, match="no pictures, expected"):
        gif([], 100)
