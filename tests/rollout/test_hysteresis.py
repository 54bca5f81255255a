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
from tests.rollout.hysteresis import Hysteresis
from tests.stages.pendulum import Pendulum

NAN = float("nan")


def drive(rule: Hysteresis, probabilities: Sequence[float], seed: int = 0) -> list[Decision]:
    rule.begin(np.random.default_rng(seed))
    unknown = np.full(2, NAN, np.float32)
    said = ({"safe_probability": each} for each in probabilities)
    return [rule.decide(Signals(np.zeros(2, np.float32), each, unknown)) for each in said]


def who(decisions: list[Decision]) -> str:
    return "".join("R" if each.reference_drives else "p" for each in decisions)


@pytest.mark.parametrize(
    ("patience", "probabilities", "expected"),
    [
        (3, [0.9, 0.5, 0.49], "ppR"),
        (1, [0.4, 0.79, 0.8, 0.5], "RRpp"),
        (3, [0.4, 0.9, 0.9, 0.7, 0.9, 0.9, 0.9], "RRRRRRp"),
        (2, [0.4, 0.9, 0.9, 0.4, 0.9, 0.9], "RRpRRp"),
        (2, [0.9, NAN, 0.9, NAN, 0.9, 0.9], "pRRRRp"),
    ],
)
def test_the_reference_keeps_the_wheel_until_it_is_safe_for_a_while(
    patience: int, probabilities: list[float], expected: str
) -> None:
    assert who(drive(Hysteresis(0.5, 0.8, patience, 0), probabilities)) == expected


def test_a_drive_knows_nothing_of_the_one_before() -> None:
    rule = Hysteresis(0.5, 0.8, 3, 0.4)
    first = drive(rule, [0.6] * 50, seed=1)
    assert who(drive(rule, [0.6, 0.4, 0.9, 0.9], seed=2)) == "pRRR"
    assert drive(rule, [0.6] * 50, seed=1) == first
    assert drive(rule, [0.6] * 50, seed=3) != first


def test_a_share_of_the_frames_is_audited() -> None:
    decisions = drive(Hysteresis(0.5, 0.8, 3, 0.1), [0.6] * 20_000)
    assert {each.ask_probability for each in decisions} == {0.1}
    assert abs(np.mean([each.asked is Asked.AUDIT for each in decisions]) - 0.1) < 0.02


@pytest.mark.parametrize("numbers", [(0.5, 0.5, 3, 0.1), (NAN, 0.8, 3, 0.1), (0.5, 1.1, 3, 0.1)])
def test_nonsense_is_refused(numbers: tuple[float, float, int, float]) -> None:
    with pytest.raises(ValueError, match="expected 0 <= cut < again <= 1"):
        Hysteresis(*numbers)


def test_it_drives_a_robot() -> None:
    """What comes into the dataset is what it decided."""
    seen = {n: of for n, of in Pendulum.features.items() if n.startswith("observation.")}
    generator = torch.Generator().manual_seed(0)
    primary = ConvActor(
        seen, Pendulum.features["action"], channels=4, hidden=8, generator=generator
    )
    driver = Driver(primary, SafetyNetwork(primary.feature_size, 8, generator=generator))

    def driven(rule: Hysteresis) -> dict[str, np.ndarray]:
        drives = record_all(
            Pendulum(length=1.5), rule, driver, count(), seed=(0,), iteration=1, workers=1
        )
        recordings = list(until_queries(drives, queries=1000, frames=60))
        drives.close()
        assert sum(len(each.episode) for each in recordings) == 60
        columns = [each.episode.columns for each in recordings]
        return {name: np.concatenate([each[name] for each in columns]) for name in columns[0]}

    said = driven(Hysteresis(0, 1, 1, 0))["safe_probability"]
    low, high = np.quantile(said, [0.4, 0.6])
    columns = driven(Hysteresis(float(low), float(high), 2, 0.3))
    because, drove = columns["asked_because"], columns["intervention"]
    assert {Asked.DROVE, Asked.AUDIT, Asked.NOT} == set(because.ravel())
    np.testing.assert_array_equal(drove, because == Asked.DROVE)
    np.testing.assert_array_equal(columns["queried"], because != Asked.NOT)
    np.testing.assert_allclose(columns["ask_probability"], np.where(drove, 1, 0.3))
    same = (columns["action"] == columns["primary_action"]).all(axis=1, keepdims=True)
    np.testing.assert_array_equal(same, ~columns["queried"])
