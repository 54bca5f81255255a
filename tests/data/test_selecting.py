from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.data.schema import FEATURES, IMAGE_SHAPE, Episode
from pipeline.data.selecting import select_unsafe, unsafe_runs
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


def test_refuses_a_column() -> None:
    with pytest.raises(ValueError, match=r"shape \(3, 1\), expected \(T,\)"):
        unsafe_runs(np.zeros((3, 1)), 0.5)
