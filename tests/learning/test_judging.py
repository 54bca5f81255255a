"""Safety policies are measured on any labelled frames, and on some of them."""

import numpy as np
import pytest
import torch

from pipeline.driving.network import PrimaryNetwork
from pipeline.learning.judging import (
    Frames,
    auroc_if_known,
    look_at,
    quality,
    situations,
)
from pipeline.learning.labels import LabelRule
from pipeline.policies.network import SafetyNetwork
from tests.episodes import random_episode, write

RULE = LabelRule("steering", 0.0, "last", [1.0, 0.5])
TAU = 0.0025


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Frames:
    """Two drives of six frames; in the second the reference drives the frames 1, 2 and 4."""
    rng = np.random.default_rng(0)
    reasons = [1] * 6, [1, 0, 0, 1, 0, 1]
    episodes = [random_episode(rng, 6, asked=of) for of in reasons]
    dataset = write(tmp_path_factory.mktemp("data") / "rollout", episodes)
    primary = PrimaryNetwork(2, generator=torch.Generator().manual_seed(0))
    safety = SafetyNetwork(primary.feature_size, 4, generator=torch.Generator().manual_seed(0))
    return look_at(primary, safety, dataset, RULE)


def test_the_time_since_a_handover_begins_where_the_reference_ends(frames: Frames) -> None:
    since = frames.numbers["since_handover"].to_numpy()
    nan = np.nan
    assert since[:6] == pytest.approx([nan] * 6, nan_ok=True)
    assert since[6:] == pytest.approx([nan, nan, nan, 0.1, nan, 0.1], nan_ok=True)


def test_a_situation_is_a_condition_on_what_has_a_name(frames: Frames) -> None:
    told = ["distance_ahead < 30 or steering > 0", "since_handover < 1", "intervention"]
    found = dict(situations(frames, told))
    assert list(found) == ["all", *told]
    numbers = frames.numbers
    assert (
        found[told[0]].tolist() == ((numbers.distance_ahead < 30) | (numbers.steering > 0)).tolist()
    )
    assert np.flatnonzero(found["since_handover < 1"]).tolist() == [9, 11]
    parts = [quality(frames, here, TAU, 0.5)["frames"] for here in found.values()]
    assert parts == [here.sum() for here in found.values()]


@pytest.mark.parametrize("wrong", ["nowhere < 2", "steering", "steering <", "1 < 2"])
def test_what_is_no_condition_is_refused(frames: Frames, wrong: str) -> None:
    with pytest.raises(ValueError, match="expected a condition") as caught:
        list(situations(frames, [wrong]))
    assert wrong in str(caught.value)


def test_the_better_the_reference_is_known_the_better_one_could_tell() -> None:
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1, 1, (2000, 2)).astype(np.float32)
    proposed = actions + rng.normal(0, 0.05, actions.shape).astype(np.float32)
    deviation = RULE.deviation(proposed, actions, np.zeros(2000, int), 10)
    nothing = np.zeros(2000, np.float32)
    known = Frames(proposed, actions, deviation, nothing, None, np.zeros(2000, int), 10)
    found = [auroc_if_known(known, RULE, TAU, error, seed=0) for error in (0, 0.02, 0.05, 1)]
    assert found[0] == 1
    assert found == sorted(found, reverse=True)
    assert found[-1] == pytest.approx(0.5, abs=0.05)
