"""Eq. 2, and labels that look ahead."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.learning.labels import (
    label_horizon,
    safe_labels,
    threshold_for_share,
)

deviations = st.lists(st.floats(0, 4, width=32), min_size=1, max_size=30)


def test_equation_2_is_1_for_safe_up_to_the_threshold_itself():
    labels = safe_labels(np.array([0.0, 0.0025, 0.0026, 1.0]), 0.0025)
    assert labels.tolist() == [True, True, False, False]


def test_what_is_not_known_is_not_labelled():
    with pytest.raises(ValueError, match="deviation is NaN in 1 of 2 frames"):
        safe_labels(np.array([0.0, np.nan]), 0.0025)


@given(deviations, st.floats(0.001, 1))
def test_the_threshold_is_the_smallest_for_its_share(values, share):
    epsilon = np.array(values, np.float32)
    tau = threshold_for_share(epsilon, share)
    assert safe_labels(epsilon, tau).mean() >= share - 1e-9
    assert np.mean(epsilon < tau) < share


def test_the_papers_share():
    assert threshold_for_share(np.arange(1, 1001) / 1000, 0.777) == 0.777


@pytest.mark.parametrize(("values", "share"), [([1.0], 0.0), ([1.0], 1.1), ([], 0.5)])
def test_a_share_of_nothing_has_no_threshold(values, share):
    with pytest.raises(ValueError, match="expected a share in"):
        threshold_for_share(np.array(values), share)


def test_labels_look_ahead_within_their_episode():
    epsilon = np.array([0.1, 0.5, 0.2, 0.3, 0.9, 0.0, 0.4])
    episode = np.array([7, 7, 7, 7, 3, 3, 3])
    last = label_horizon(epsilon, episode, 2, "last")
    assert last.tolist() == [0.2, 0.3, 0.3, 0.3, 0.4, 0.4, 0.4]
    largest = label_horizon(epsilon, episode, 2, "max")
    assert largest.tolist() == [0.5, 0.5, 0.3, 0.3, 0.9, 0.4, 0.4]


@given(st.lists(deviations, min_size=1, max_size=5), st.integers(0, 40))
def test_whatever_the_episodes_a_label_is_of_the_future_of_its_own(episodes, horizon):
    epsilon = np.concatenate([np.array(values) for values in episodes])
    index = np.repeat(np.arange(len(episodes)), [len(values) for values in episodes])
    last = label_horizon(epsilon, index, horizon, "last")
    largest = label_horizon(epsilon, index, horizon, "max")
    start = 0
    for values in episodes:
        for t in range(len(values)):
            window = values[t : t + horizon + 1]
            assert last[start + t] == window[-1]
            assert largest[start + t] == max(window)
        start += len(values)


@pytest.mark.parametrize("mode", ["last", "max"])
def test_no_horizon_is_the_deviation_itself(mode):
    epsilon = np.array([0.3, 0.1])
    assert np.array_equal(label_horizon(epsilon, np.array([0, 0]), 0, mode), epsilon)
    assert len(label_horizon(np.array([]), np.array([], int), 3, mode)) == 0


@pytest.mark.parametrize(("horizon", "mode"), [(-1, "last"), (1, "mean")])
def test_other_horizons_are_refused(horizon, mode):
    with pytest.raises(ValueError, match="expected at least 0 and 'last' or 'max'"):
        label_horizon(np.zeros(2), np.zeros(2, int), horizon, mode)


def test_an_episode_in_pieces_is_refused():
    with pytest.raises(ValueError, match="an episode in pieces"):
        label_horizon(np.zeros(3), np.array([0, 1, 0]), 1, "max")
