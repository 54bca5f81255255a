from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.data.schema import FEATURES, IMAGE_SHAPE, Episode
from pipeline.data.selecting import check_unsafe, sample_frames, select_unsafe, unsafe_runs
from tests.episodes import random_episode

probability = st.one_of(st.sampled_from([0.0, 0.5, 1.0, float("nan")]), st.floats(0, 1, width=32))
probabilities = st.lists(probability, max_size=40).map(lambda p: np.array(p, np.float32))
cuts = st.floats(0, 1, width=32)


@given(probabilities, cuts)
def test_runs_cover_the_unsafe_rows_and_no_others(safe: np.ndarray, cut: float) -> None:
    covered = [row for run in unsafe_runs(safe, cut) for row in range(run.start, run.stop)]
    assert covered == [row for row, p in enumerate(safe.tolist()) if p < cut]


@given(probabilities, cuts)
def test_runs_are_as_long_as_can_be(safe: np.ndarray, cut: float) -> None:
    runs = unsafe_runs(safe, cut)
    assert all(run.start < run.stop for run in runs)
    assert all(a.stop < b.start for a, b in pairwise(runs))


@pytest.mark.parametrize(
    ("safe", "expected"),
    [
        ([], []),
        ([0.9, 0.8], []),
        ([0.1, 0.2], [slice(0, 2)]),
        ([0.5, 0.4, 0.5], [slice(1, 2)]),
        ([0.4, 0.6, 0.4, 0.4], [slice(0, 1), slice(2, 4)]),
        ([0.4, float("nan"), 0.4], [slice(0, 1), slice(2, 3)]),
    ],
)
def test_runs_by_hand(safe: list[float], expected: list[slice]) -> None:
    assert unsafe_runs(np.array(safe, np.float32), 0.5) == expected


@given(st.lists(st.integers(1, 12), max_size=4), st.integers(0, 2**32 - 1), cuts)
def test_selection_keeps_the_unsafe_rows_as_they_were(
    lengths: list[int], seed: int, cut: float
) -> None:
    rng = np.random.default_rng(seed)
    raw = [
        random_episode(
            rng,
            frames,
            episode=number,
            task=f"track {number}",
            images=np.zeros((frames, *IMAGE_SHAPE), np.uint8),
        )
        for number, frames in enumerate(lengths)
    ]
    selected = list(select_unsafe(raw, cut))

    for run in selected:
        frames = run.columns["source.frame"][:, 0]
        assert (np.diff(frames) == 1).all(), "an episode has a gap in time"
        origin = raw[run.columns["source.episode"][0, 0]]
        assert run.task == origin.task
        for name in FEATURES:
            rows = origin.columns[name][frames[0] : frames[-1] + 1]
            np.testing.assert_array_equal(run.columns[name], rows)
    unsafe = sum(int((episode.columns["safe_probability"] < cut).sum()) for episode in raw)
    assert sum(len(run) for run in selected) == unsafe


def test_without_a_safety_policy_nothing_is_unsafe() -> None:
    drive = random_episode(np.random.default_rng(0), 5, reference_only=True)
    assert list(select_unsafe([drive], 1.0)) == []


@pytest.mark.parametrize("cut", [-0.1, 1.1, float("nan")])
def test_refuses_a_cut_that_is_no_probability(cut: float) -> None:
    def untouched() -> Iterator[Episode]:
        raise AssertionError("asked for an episode")
        yield

    with pytest.raises(ValueError, match="cut is"):
        select_unsafe(untouched(), cut)
    with pytest.raises(ValueError, match="cut is"):
        unsafe_runs(np.zeros(3), cut)


def test_what_a_safety_policy_called_safe_throughout_has_nothing_to_select(rollout_1: Path) -> None:
    check_unsafe(rollout_1, 0.5)
    message = f"^{rollout_1}: no frame has a safe_probability below the cut, 0$"
    with pytest.raises(ValueError, match=message):
        check_unsafe(rollout_1, 0)


def test_refuses_a_column() -> None:
    with pytest.raises(ValueError, match=r"shape \(3, 1\), expected \(T,\)"):
        unsafe_runs(np.zeros((3, 1)), 0.5)


def source(episodes: list[Episode]) -> list[tuple[int, int]]:
    return [
        (int(number), int(frame))
        for episode in episodes
        for number, frame in zip(
            episode.columns["source.episode"][:, 0],
            episode.columns["source.frame"][:, 0],
            strict=True,
        )
    ]


@given(st.lists(st.integers(1, 9), min_size=1, max_size=4), st.data())
def test_a_sample_has_so_many_frames_each_at_most_once_and_no_gaps(
    lengths: list[int], data: st.DataObject
) -> None:
    raw = [blank(frames, number) for number, frames in enumerate(lengths)]
    wanted = data.draw(st.integers(1, sum(lengths)))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    kept = list(sample_frames(raw, sum(lengths), wanted, rng))
    rows = source(kept)
    assert len(rows) == len(set(rows)) == wanted
    assert rows == sorted(rows) and set(rows) <= set(source(raw))
    for episode in kept:
        frames = episode.columns["source.frame"][:, 0]
        assert np.all(np.diff(frames) == 1)


def test_a_sample_is_uniform() -> None:
    """Each of 10 frames is drawn 300 times of 1000 on average; 5 deviations off is 1 in a million."""
    drawn: list[int] = []
    for seed in range(1000):
        kept = sample_frames([blank(4, 0), blank(6, 1)], 10, 3, np.random.default_rng(seed))
        drawn += [4 * number + frame for number, frame in source(list(kept))]
    assert np.all(np.abs(np.bincount(drawn, minlength=10) - 300) < 5 * np.sqrt(1000 * 0.3 * 0.7))


@pytest.mark.parametrize("frames", [0, 11])
def test_a_sample_is_no_larger_than_the_dataset(frames: int) -> None:
    with pytest.raises(ValueError, match=f"frames is {frames}, expected 1 to the 10"):
        sample_frames([], 10, frames, np.random.default_rng(0))


def blank(frames: int, number: int) -> Episode:
    images = np.zeros((frames, *IMAGE_SHAPE), np.uint8)
    return random_episode(np.random.default_rng(0), frames, episode=number, images=images)
