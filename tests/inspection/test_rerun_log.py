"""Recordings, read back from the file."""

import weakref
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pytest
from rerun.experimental import RrdReader

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Episode
from pipeline.driving.features import ACTIONS, AFFORDANCES, CAMERA
from pipeline.inspection.excerpts import (
    Excerpt,
    around_takeovers,
    ranked_takeovers,
    whole_episodes,
)
from pipeline.inspection.rerun_blueprints import drive_blueprint
from pipeline.inspection.rerun_log import log_excerpt
from pipeline.inspection.rerun_sinks import into_file
from tests.episodes import LABELS, random_episode, write
from tests.inspection.saved import column, origins, recordings

FPS, CUT, TAU = 10, 0.25, 0.01
BLUEPRINT = drive_blueprint(FPS)
LANES = {f"/around/{name}" for name in AFFORDANCES[:5]}
LANES |= {f"/who/{name}" for name in ("drove", "was_asked", "deviation")}
PLOTS = {
    *(f"/action/{who}_{what}" for who in ("primary", "reference") for what in ACTIONS),
    *(f"/safe_probability/{name}" for name in ("safe_probability", "cut", "reference_drives")),
    *("/deviation/deviation", "/deviation/tau", "/speed/speed"),
    *(f"/distance/{name}" for name in AFFORDANCES[5:8]),
    *(f"/in_lane/{name}" for name in AFFORDANCES[8:]),
}
TOP_VIEW = {f"/top_view/{name}" for name in ("driven", "others", "car", "heading")}


@pytest.fixture(scope="module")
def episodes() -> list[Episode]:
    """A drive of the reference; one of primary and reference, longer than a batch of images."""
    rng = np.random.default_rng(0)
    return [
        random_episode(rng, 5, task="drive on alder with 3 other cars", reference_only=True),
        random_episode(rng, 70, task="drive on birch with 0 other cars", iteration=2, episode=1),
    ]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory, episodes: list[Episode]) -> Dataset:
    path, labels = tmp_path_factory.mktemp("datasets") / "rollout", LABELS | {"tau": TAU}
    return write(path, episodes, "rollout", cut=CUT, labels=labels)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory, dataset: Dataset) -> Path:
    """All episodes of `dataset` in one file."""
    return save(tmp_path_factory.mktemp("saved") / "all.rrd", list(whole_episodes(dataset)))


def save(path: Path, excerpts: list[Excerpt]) -> Path:
    with into_file(path, BLUEPRINT) as sink:
        for excerpt in excerpts:
            log_excerpt(excerpt, sink.connect, fps=FPS)
    return path


def test_every_episode_is_a_recording_with_every_row_of_every_entity(
    saved: Path, episodes: list[Episode]
) -> None:
    """On both timelines; lanes in one piece: the viewer shows no more of them than it gets at first."""
    for number, (entry, episode) in enumerate(zip(recordings(saved), episodes, strict=True)):
        assert entry.application_id == "safedagger"
        assert entry.recording_id == f"rollout/episode_{number:04d}"
        rows: Counter[str] = Counter()
        pieces: Counter[str] = Counter()
        for chunk in RrdReader(saved).stream(store=entry).to_chunks():
            if chunk.timeline_names:
                assert set(chunk.timeline_names) == {"frame_index", "timestamp"}
                rows[chunk.entity_path] += chunk.num_rows
                pieces[chunk.entity_path] += 1
        assert rows == dict.fromkeys(LANES | PLOTS | TOP_VIEW | {"/camera"}, len(episode))
        assert {pieces[lane] for lane in LANES} == {1}


def test_the_blueprint_travels_in_the_file(saved: Path) -> None:
    shown = origins(saved)
    for entity in LANES | PLOTS | {"/camera"}:
        assert any(
            f"{entity}/".startswith(f"/{origin.strip('/')}/") for origin in shown if origin != "/"
        ), entity


def test_the_camera_is_shown_without_loss(saved: Path, episodes: list[Episode]) -> None:
    entry = recordings(saved)[1]
    blobs = column(saved, entry, "/camera", "blob")
    for blob, image in zip(blobs, episodes[1].columns[CAMERA], strict=True):
        shown = cv2.imdecode(np.frombuffer(bytes(blob), np.uint8), cv2.IMREAD_COLOR_RGB)
        np.testing.assert_array_equal(shown, image)


def test_what_each_policy_wanted(saved: Path, episodes: list[Episode]) -> None:
    entry, rows = recordings(saved)[1], episodes[1].columns
    queried = rows["queried"][:, 0]
    for i, name in enumerate(("steering", "brake")):
        primary = column(saved, entry, f"/action/primary_{name}", "scalars")
        reference = column(saved, entry, f"/action/reference_{name}", "scalars")
        np.testing.assert_array_equal(primary, rows["primary_action"][:, i])
        expected = np.where(queried, rows["action"][:, i], np.nan)
        np.testing.assert_array_equal(reference, expected)


def test_who_drove_and_why(saved: Path, episodes: list[Episode]) -> None:
    entry, rows = recordings(saved)[1], episodes[1].columns
    drove = np.where(rows["intervention"][:, 0], "reference", "primary")
    assert column(saved, entry, "/who/drove", "state") == drove.tolist()
    deviation = rows["deviation"][:, 0]
    states = ["" if np.isnan(d) else "above tau" if d > TAU else "up to tau" for d in deviation]
    assert column(saved, entry, "/who/deviation", "state") == states
    np.testing.assert_array_equal(
        column(saved, entry, "/deviation/deviation", "scalars"), deviation
    )
    for entity, value in (("/safe_probability/cut", CUT), ("/deviation/tau", TAU)):
        assert set(column(saved, entry, entity, "scalars")) == {value}


def test_tau_stands_beside_what_the_labels_call_a_deviation(
    episodes: list[Episode], tmp_path: Path
) -> None:
    """Of a safety policy that knows brakes, the brake is in it: a wrong one is above any tau."""
    labels = LABELS | {"measure": "steering-and-brake"}
    dataset = write(tmp_path / "braking", episodes, "rollout", cut=CUT, labels=labels)
    (excerpt,) = whole_episodes(dataset, 1)
    path = save(tmp_path / "braking.rrd", [excerpt])
    (entry,) = recordings(path)
    rows = episodes[1].columns
    squares = (rows["primary_action"] - rows["action"]) ** 2
    expected = np.where(rows["queried"][:, 0], squares.sum(axis=1), np.nan)
    shown = column(path, entry, "/deviation/deviation", "scalars")
    np.testing.assert_allclose(shown, expected)
    assert (expected > rows["deviation"][:, 0]).any()


def test_without_a_safety_policy_nothing_is_called_unsafe(
    episodes: list[Episode], tmp_path: Path
) -> None:
    dataset = write(tmp_path / "D_0", episodes[:1])
    path = save(tmp_path / "D_0.rrd", list(whole_episodes(dataset)))
    (entry,) = recordings(path)
    shown = {chunk.entity_path for chunk in RrdReader(path).stream(store=entry).to_chunks()}
    unknown = {"/safe_probability/cut", "/deviation/tau", "/who/deviation"}
    assert not shown & unknown
    assert shown >= (LANES | PLOTS) - unknown


def test_one_episode_only(dataset: Dataset, episodes: list[Episode]) -> None:
    (excerpt,) = whole_episodes(dataset, 1)
    assert excerpt.title == "episode 0001: iteration 2, drive on birch with 0 other cars"
    np.testing.assert_array_equal(excerpt.episode.columns[CAMERA], episodes[1].columns[CAMERA])
    for unknown in (-1, 2):
        with pytest.raises(ValueError, match=f"no episode {unknown}, expected 0 to 1"):
            whole_episodes(dataset, unknown)
        with pytest.raises(ValueError, match="expected 0 to 1"):
            ranked_takeovers(dataset, unknown)


def test_takeovers_keep_the_time_of_their_episode(
    dataset: Dataset, episodes: list[Episode], tmp_path: Path
) -> None:
    excerpts = list(around_takeovers(dataset, ranked_takeovers(dataset)))
    assert excerpts[-1].title.startswith("takeover 0001: ")
    probability = episodes[1].columns["safe_probability"][:, 0]
    assert f"safe probability {probability.min():.3f}" in excerpts[-1].title
    first, stop = excerpts[-1].first_frame, excerpts[-1].first_frame + len(excerpts[-1])
    assert first <= probability.argmin() < stop
    path = save(tmp_path / "unsafe.rrd", excerpts[-1:])
    (entry,) = recordings(path)
    drove = np.where(episodes[1].columns["intervention"][first:stop, 0], "reference", "primary")
    assert column(path, entry, "/who/drove", "state") == drove.tolist()


def test_takeovers_are_ranked_by_their_titles(dataset: Dataset) -> None:
    titles = [excerpt.title for excerpt in around_takeovers(dataset, ranked_takeovers(dataset))]
    assert [title[:14] for title in sorted(titles)] == [
        f"takeover {rank:04d}:" for rank in range(1, len(titles) + 1)
    ]
    probabilities = [float(title.split()[10].strip(",")) for title in sorted(titles)]
    assert probabilities == sorted(probabilities)


def test_few_episodes_are_in_memory_at_a_time(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    many = write(tmp_path / "many", (random_episode(rng, 12) for _ in range(8)))
    seen: list[weakref.ref[np.ndarray]] = []
    for excerpt in around_takeovers(many, ranked_takeovers(many)):
        images = excerpt.episode.columns[CAMERA].base
        if not any(images is image() for image in seen):
            seen.append(weakref.ref(images))
        del images, excerpt
        assert sum(image() is not None for image in seen) <= 2  # this one and the most unsafe
    assert len(seen) == 8


def test_where_the_reference_drove_alone_is_no_takeover(dataset: Dataset) -> None:
    with pytest.raises(ValueError, match="episode 0 has no takeovers"):
        ranked_takeovers(dataset, 0)
