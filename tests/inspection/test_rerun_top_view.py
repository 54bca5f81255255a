"""The top view, read back from the file."""

from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader, StoreEntry

from pipeline.driving.cars import LENGTH, WIDTH
from pipeline.driving.tracks import SHOULDER, make_track
from pipeline.inspection.excerpts import Excerpt
from pipeline.inspection.footage import Footage
from pipeline.inspection.rerun_blueprints import drive_blueprint
from pipeline.inspection.rerun_log import BLUE, RED, log_excerpt
from pipeline.inspection.rerun_sinks import into_file
from pipeline.policies.inference import Driver
from pipeline.rollout.recording import record
from pipeline.rollout.rules.mixture import Mixture
from tests.drives import plan
from tests.inspection.saved import batches, column, recordings

NORTH_UP = np.array([1, -1])


@pytest.fixture(scope="module")
def excerpt(driver: Driver) -> Excerpt:
    """By turns an untrained primary and the reference drive for 8 s, longer than is sent at once."""
    long = plan(Mixture(0.8), traffic=40, seconds=8.0)
    episode = record(long, driver, 0, 0).episode
    assert len(episode) > 64 and 0 < episode.columns["intervention"].mean() < 1
    return Excerpt("title", "name", episode, 0)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory, excerpt: Excerpt) -> Path:
    path = tmp_path_factory.mktemp("saved") / "one.rrd"
    with into_file(path, drive_blueprint(10)) as sink:
        log_excerpt(excerpt, sink.connect, fps=10)
    return path


def test_the_driven_line_is_the_cars_way_coloured_by_who_drove(
    saved: Path, excerpt: Excerpt
) -> None:
    (entry,) = recordings(saved)
    rows = excerpt.episode.columns
    strips = np.array(column(saved, entry, "/top_view/driven", "strips"))
    np.testing.assert_array_equal(strips[:, 0], rows["vehicle_state"][:, :2] * NORTH_UP)
    np.testing.assert_array_equal(strips[:-1, 1], strips[1:, 0])
    colors = np.where(rows["intervention"][:, 0], RED, BLUE).tolist()
    assert column(saved, entry, "/top_view/driven", "colors") == colors
    assert column(saved, entry, "/top_view/car", "colors") == colors


def test_our_car_is_as_long_as_it_is_and_points_ahead(saved: Path, excerpt: Excerpt) -> None:
    (entry,) = recordings(saved)
    x, y, heading, _ = excerpt.episode.columns["vehicle_state"].T
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1) * NORTH_UP
    strips = np.array(column(saved, entry, "/top_view/car", "strips"))
    middle = np.stack([x, y], axis=1) * NORTH_UP
    np.testing.assert_allclose(strips.mean(axis=1), middle, atol=1e-4)
    bumpers = (LENGTH - WIDTH) * ahead  # but for the round ends
    np.testing.assert_allclose(strips[:, 1] - strips[:, 0], bumpers, atol=1e-3)
    arrows = np.array(column(saved, entry, "/top_view/heading", "vectors"))
    np.testing.assert_allclose(arrows / np.hypot(*arrows.T)[:, None], ahead, atol=1e-5)


def test_the_other_cars_are_there_while_they_are_known(saved: Path, excerpt: Excerpt) -> None:
    (entry,) = recordings(saved)
    known = Footage.of_episode(excerpt.episode).others
    shown = batches(saved, entry, "/top_view/others", "strips")
    counts = [len(cars) for cars in known]
    assert [len(strips) for strips in shown] == counts
    assert min(counts) < max(counts)
    for strips, cars in zip(shown, known, strict=True):
        middle = np.array(strips).reshape(-1, 2, 2).mean(axis=1)
        np.testing.assert_allclose(middle, cars[:, :2] * NORTH_UP, atol=1e-4)


def test_the_road(saved: Path) -> None:
    (entry,) = recordings(saved)
    track = make_track("alder")
    roads = static_strips(saved, entry)
    assert set(roads) == {"/track/asphalt", "/track/edges", "/track/lanes"}
    assert len(roads["/track/asphalt"]) == 1 and len(roads["/track/edges"]) == 2
    for strip, d in zip(roads["/track/edges"], (-1, 1), strict=True):
        x, y = np.array(strip).T * NORTH_UP[:, None]
        s = np.linspace(0, track.length, len(strip))
        edge = d * (track.half_width - SHOULDER)
        np.testing.assert_allclose(track.centreline.local_coordinates(x, y, s)[1], edge, atol=0.02)


def static_strips(path: Path, entry: StoreEntry) -> dict[str, list]:
    """The strips of each entity that does not change."""
    chunks = RrdReader(path).stream(store=entry).to_chunks()
    rows = {
        chunk.entity_path: chunk.to_record_batch().to_pydict()
        for chunk in chunks
        if chunk.is_static
    }
    name = "LineStrips2D:strips"
    return {entity: row[name][0] for entity, row in rows.items() if name in row}
