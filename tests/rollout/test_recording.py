from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.data.schema import Asked
from pipeline.driving.features import CAMERA
from pipeline.rollout.plans import Plan
from pipeline.rollout.recording import Recording, record, record_all, until_queries
from pipeline.rollout.rules.audit import Audit
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.workers import in_order
from tests.drives import plan, untrained
from tests.episodes import random_episode

PLAN = plan(Safe(0.5), seed=(0, 0, 0), offset_spread=0.3, angle_spread=0.05)
TASK = PLAN.task


def recordings(lengths: list[int], seed: int) -> list[Recording]:
    rng = np.random.default_rng(seed)
    episodes = [random_episode(rng, length, iteration=1) for length in lengths]
    return [
        Recording(
            episode,
            np.zeros((len(episode), 2), np.float32),
            [{"distance_m": n + 1.0, "touches": n // 3} for n in range(len(episode))],
        )
        for episode in episodes
    ]


@given(
    st.lists(st.integers(1, 12), min_size=1, max_size=5),
    st.integers(1, 30),
    st.integers(1, 60),
    st.integers(0, 9),
)
@settings(max_examples=30, deadline=None)
def test_a_budget_is_spent_and_never_overdrawn(
    lengths: list[int], queries: int, frames: int, seed: int
) -> None:
    whole = recordings(lengths, seed)
    kept = list(until_queries(whole, queries, frames))
    asked, driven = sum(r.queries for r in kept), sum(len(r.episode) for r in kept)
    assert asked == queries or driven == frames or driven == sum(lengths)
    assert asked <= queries and driven <= frames
    for cut_short, original in zip(kept, whole, strict=False):
        length = len(cut_short.episode)
        assert np.array_equal(
            cut_short.episode.columns[CAMERA], original.episode.columns[CAMERA][:length]
        )
        if length < len(original.episode):
            ending = cut_short.episode.ending
            assert ending["ended"] == "budget spent"
            assert (ending["frames"], ending["distance_m"]) == (length, float(length))
            assert (ending["touches"], ending["put_back"]) == ((length - 1) // 3, 0)


def test_the_result_does_not_depend_on_the_number_of_workers() -> None:
    jobs = [(replace(PLAN, seed=(0, 0, n)), untrained(), 1, n) for n in range(3)]
    alone, together = (list(in_order(record, jobs, workers)) for workers in (1, 2))
    for a, b in zip(alone, together, strict=True):
        assert a.reference_actions.tobytes() == b.reference_actions.tobytes()
        for name, values in a.episode.columns.items():
            assert values.tobytes() == b.episode.columns[name].tobytes(), name


def test_drives_go_around_the_tracks_each_with_a_seed_of_its_own() -> None:
    task = replace(TASK, tracks="alder,yew", seconds=0.2)
    numbers, seed = [0, 1, 2], (7, 1)
    drives = record_all(task, Safe(0.5), untrained(), numbers, seed=seed, iteration=4, workers=1)
    for number, recording in enumerate(drives):
        expected = Plan(task, ["alder", "yew"][number % 2], Safe(0.5), (7, 1, number))
        again = record(expected, untrained(), 4, number)
        assert recording.episode.task == expected.description
        for name, values in again.episode.columns.items():
            assert values.tobytes() == recording.episode.columns[name].tobytes(), name


@pytest.mark.parametrize(
    ("rule", "drives"), [(Naive(), False), (Safe(0.0), False), (Safe(1.0), True)]
)
def test_where_the_reference_drives_it_is_asked_and_else_nothing_is_told_of_it(
    rule: Rule, drives: bool
) -> None:
    """A dataset never tells what nobody paid for."""
    columns = record(replace(PLAN, rule=rule), untrained(), 1, 0).episode.columns
    assert np.all(columns["intervention"] == drives)
    assert np.all(columns["queried"] == drives)
    assert np.all(np.isnan(columns["deviation"]) != drives)
    if drives:
        apart = columns["action"] - columns["primary_action"]
        np.testing.assert_allclose(columns["deviation"], apart[:, :1] ** 2, rtol=1e-5)
    else:
        assert np.array_equal(columns["action"], columns["primary_action"])


@pytest.mark.parametrize(
    ("rule", "reasons"),
    [
        (Reference(), {Asked.DROVE}),
        (Safe(1.0), {Asked.DROVE}),
        (Safe(0.0), {Asked.NOT}),
        (Mixture(0.5), {Asked.DROVE, Asked.MIXTURE}),
    ],
)
def test_it_says_why_the_reference_was_asked(rule: Rule, reasons: set[Asked]) -> None:
    columns = record(replace(PLAN, rule=rule), untrained(), 1, 0).episode.columns
    because, probability = columns["asked_because"][:, 0], columns["ask_probability"][:, 0]
    assert set(because.tolist()) == reasons
    drove = columns["intervention"][:, 0]
    assert np.array_equal(because == Asked.DROVE, drove)
    assert np.array_equal(because != Asked.NOT, columns["queried"][:, 0])
    assert np.array_equal(probability, columns["queried"][:, 0])


@pytest.mark.parametrize(
    ("change", "ended", "put_back"),
    [
        ({"seconds": 1.0}, "out of time", 0),
        ({"laps": 0.01, "seconds": 30.0}, "laps done", 0),
        ({"seconds": 60.0}, "road left", 1),
    ],
)
def test_a_drive_says_how_it_ended(change: dict, ended: str, put_back: int) -> None:
    """An untrained primary does not steer."""
    rule = Naive() if put_back else Reference()
    to_drive = replace(PLAN, rule=rule, task=replace(TASK, **change))
    driven = record(to_drive, untrained(), 1, 7)
    ending = driven.episode.ending
    assert (ending["ended"], ending["put_back"]) == (ended, put_back)
    assert (ending["episode"], ending["task"]) == (7, to_drive.description)
    assert ending["frames"] == len(driven.episode) == len(driven.outcomes)
    x, y = driven.episode.columns["vehicle_state"][[0, -1], :2].T
    assert ending["distance_m"] > 0.9 * np.hypot(np.diff(x), np.diff(y))[0]


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
def test_a_mixture_asks_about_every_frame_and_drives_some(beta: float) -> None:
    """Dagger: all that is collected is a query (Sec. 2.6), whoever drove."""
    recording = record(replace(PLAN, rule=Mixture(beta)), untrained(), 1, 0)
    columns = recording.episode.columns
    assert recording.queries == len(recording.episode)
    assert np.array_equal(columns["action"], recording.reference_actions)
    assert not np.isnan(columns["deviation"]).any()
    share = columns["intervention"].mean()
    assert share == beta if beta in (0.0, 1.0) else 0 < share < 1


def test_an_audit_labels_and_counts_what_the_primary_drives_on_undisturbed() -> None:
    alone, audited = (
        record(replace(PLAN, rule=Audit(Safe(0.0), share)), untrained(), 1, 0)
        for share in (0.0, 1.0)
    )
    columns = audited.episode.columns
    assert (alone.queries, audited.queries) == (0, len(audited.episode))
    assert np.array_equal(columns["action"], audited.reference_actions)
    assert not columns["intervention"].any() and not np.isnan(columns["deviation"]).any()
    for name in ("primary_action", "vehicle_state", CAMERA):
        assert np.array_equal(columns[name], alone.episode.columns[name]), name


def test_whoever_has_enough_stops_without_a_warning(recwarn: pytest.WarningsRecorder) -> None:
    short = replace(TASK, seconds=0.2)
    plans = (replace(PLAN, task=short, seed=(0, 0, n)) for n in count())
    results = in_order(record, ((plan, untrained(), 1, 0) for plan in plans), 2)
    next(results)
    results.close()
    assert [str(warning.message) for warning in recwarn] == []
