from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from pipeline.data.dataset import Dataset
from pipeline.data.selecting import select
from pipeline.driving.network import PrimaryNetwork
from pipeline.learning.labels import LabelRule
from pipeline.learning.safety import MOST, Judged, apart, judge
from tests.episodes import random_episode, write

PRIMARY = PrimaryNetwork(2, generator=torch.Generator().manual_seed(0))
RULE = LabelRule(measure="steering", horizon=0.0, mode="last")


def judged(lengths: list[int]) -> Judged:
    index = np.repeat(np.arange(len(lengths)), lengths)
    rows = len(index)
    return Judged(np.zeros((rows, 2), np.float16), np.zeros(rows, "f4"), index, np.ones(rows))


def test_a_dataset_is_judged_frame_by_frame(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    episodes = [
        random_episode(rng, 3, reference_only=True),
        random_episode(rng, 2, reference_only=True),
    ]
    dataset = write(tmp_path / "D", episodes)
    seen = judge(PRIMARY, dataset, rule=RULE)
    assert seen.features.shape == (5, PRIMARY.feature_size)
    assert seen.episode_index.tolist() == [0, 0, 0, 1, 1]
    proposed = PRIMARY(
        torch.from_numpy(episodes[0].columns["observation.images.front"]).permute(0, 3, 1, 2) / 255
    )
    steering = proposed["steering"].detach().numpy().clip(-1, 1)
    action = dataset.columns(["action"])["action"][:3, 0]
    assert seen.deviation[:3] == pytest.approx((steering - action) ** 2, abs=0.02)


def test_labels_look_ahead_by_seconds_and_within_an_episode(tmp_path: Path) -> None:
    """At 10 frames a second, 0.2 s are two frames."""
    rng = np.random.default_rng(0)
    episodes = [random_episode(rng, n, reference_only=True) for n in (4, 2)]
    dataset = write(tmp_path / "D", episodes)
    now, ahead = (
        judge(PRIMARY, dataset, rule=LabelRule("steering", seconds, "last"))
        for seconds in (0.0, 0.2)
    )
    assert ahead.deviation.tolist() == now.deviation[[2, 3, 3, 3, 5, 5]].tolist()


def test_frames_without_a_label_are_left_out_and_nothing_looks_over_them(tmp_path: Path) -> None:
    episode = random_episode(np.random.default_rng(0), 6, asked=[0, 0, -1, 0, 0, 0])
    raw = write(tmp_path / "raw", [episode])
    select(raw, tmp_path / "new")
    ahead = LabelRule("steering", 0.1, "last")
    of_raw, of_new = (judge(PRIMARY, d, rule=ahead) for d in (raw, Dataset.open(tmp_path / "new")))
    assert of_raw.episode_index.tolist() == [0, 0, 1, 1, 1]
    for name in ("features", "deviation", "episode_index"):
        np.testing.assert_array_equal(getattr(of_raw, name), getattr(of_new, name))


def test_an_audited_frame_stands_for_those_that_were_not_but_not_for_too_many(
    tmp_path: Path,
) -> None:
    """And one that somebody labelled, who knows with which probability, for itself."""
    episode = random_episode(np.random.default_rng(0), 4, reference_only=True)
    episode.columns["ask_probability"][:, 0] = [1, 0.25, 0.01, np.nan]
    dataset = write(tmp_path / "D", [episode])
    weight = judge(PRIMARY, dataset, rule=RULE).weight
    assert weight.tolist() == [1, 4, MOST, 1]


@given(st.lists(st.integers(1, 5), min_size=2, max_size=20), st.floats(0, 1), st.integers(0, 99))
def test_episodes_are_held_out_whole(lengths: list[int], share: float, seed: int) -> None:
    frames = judged(lengths)
    count = round(share * len(lengths))
    rng = np.random.default_rng(seed)
    if not 0 < count < len(lengths):
        with pytest.raises(ValueError, match="expected some on both sides"):
            apart(frames, share, rng, "held_out")
        return
    kept = apart(frames, share, rng, "held_out")
    assert len(np.unique(frames.episode_index[kept])) == count
    assert not set(frames.episode_index[kept]) & set(frames.episode_index[~kept])


def test_episodes_of_two_sets_stay_apart() -> None:
    both = judged([2, 1]) + judged([3])
    assert len(both.weight) == 6
    assert both.episode_index.tolist() == [0, 0, 1, 2, 2, 2]
