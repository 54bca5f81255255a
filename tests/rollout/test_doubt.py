from collections.abc import Sequence
from itertools import count

import numpy as np
import pytest
import torch

from pipeline.data.schema import Asked
from pipeline.policies.conv import ConvActor
from pipeline.policies.inference import Driver
from pipeline.policies.network import SafetyNetwork
from pipeline.rollout.recording import record_all, until_queries
from pipeline.rollout.rules.rule import Decision, Signals
from tests.rollout.doubt import Doubt
from tests.stages.pendulum import Pendulum

NAN = float("nan")


def drive(rule: Doubt, probabilities: Sequence[float], seed: int = 0) -> list[Decision]:
    rule.begin(np.random.default_rng(seed))
    unknown = np.full(2, NAN, np.float32)
    said = ({"safe_probability": each} for each in probabilities)
    return [rule.decide(Signals(np.zeros(2, np.float32), each, unknown)) for each in said]


def test_a_drive_knows_nothing_of_the_one_before() -> None:
    rule = Doubt(2)
    first = drive(rule, [0.6, 0.4, 0.6, NAN, 0.9], seed=1)
    assert [each.reference_drives for each in first] == [False, False, False, True, True]
    assert not drive(rule, [0.4], seed=2)[0].reference_drives
    assert drive(rule, [0.6, 0.4, 0.6, NAN, 0.9], seed=1) == first


def test_what_is_doubted_is_asked_as_often() -> None:
    decisions = drive(Doubt(1), [0.7] * 20_000)
    assert decisions[0].ask_probability == pytest.approx(0.3)
    assert abs(np.mean([each.asked is Asked.AUDIT for each in decisions]) - 0.3) < 0.02


def test_it_drives_a_robot() -> None:
    """What comes into the dataset is what it decided."""
    seen = {n: of for n, of in Pendulum.features.items() if n.startswith("observation.")}
    generator = torch.Generator().manual_seed(0)
    primary = ConvActor(
        seen, Pendulum.features["action"], channels=4, hidden=8, generator=generator
    )
    driver = Driver(primary, SafetyNetwork(primary.feature_size, 8, generator=generator))
    drives = record_all(
        Pendulum(length=1.5), Doubt(9), driver, count(), seed=(0,), iteration=1, workers=1
    )
    recordings = list(until_queries(drives, queries=1000, frames=60))
    drives.close()
    assert sum(len(each.episode) for each in recordings) == 60
    columns = {
        name: np.concatenate([each.episode.columns[name] for each in recordings])
        for name in recordings[0].episode.columns
    }
    because, drove = columns["asked_because"], columns["intervention"]
    assert {Asked.AUDIT, Asked.NOT} <= set(because.ravel())
    np.testing.assert_array_equal(drove, because == Asked.DROVE)
    np.testing.assert_array_equal(columns["queried"], because != Asked.NOT)
    doubt = 1 - columns["safe_probability"]
    np.testing.assert_allclose(columns["ask_probability"], np.where(drove, 1, doubt), atol=1e-6)
    same = (columns["action"] == columns["primary_action"]).all(axis=1, keepdims=True)
    np.testing.assert_array_equal(same, ~columns["queried"])
