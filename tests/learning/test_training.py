"""Both trainings on tiny problems that can be solved."""

import subprocess
import sys

import numpy as np
import pytest
import torch

from pipeline.driving.deviation import steering
from pipeline.driving.features import CAMERA, IMITATED
from pipeline.driving.lesson import DrivingLesson
from pipeline.learning.labels import safe_labels
from pipeline.learning.settings import Optimisation, SafetySettings
from pipeline.learning.training import (
    EXTREME,
    class_weights,
    log_sizes,
    safe_probabilities,
    train_primary,
    train_safety,
)
from pipeline.policies.inference import propose

FRAMES = 240


def lesson(**fields) -> DrivingLesson:
    given = {"channels": 4, "jitter": 0.0, "mirror": False, "brake_cut": 0.5}
    weights = {"steering_weight": 20.0, "brake_weight": 1.0, "brake_on": 3.0}
    return DrivingLesson(**given | weights | fields)


def settings(**fields) -> Optimisation:
    given = {
        "optimizer": "adamw",
        "learning_rate": 3e-3,
        "weight_decay": 0.01,
        "samples": FRAMES * 5,
        "batch": 16,
        "validation": 0.2,
        "threads": 1,
    }
    return Optimisation(**given | fields)


def train(drives, told: Optimisation, of: DrivingLesson | None = None, **more):
    columns = dict(zip((CAMERA, "action", "affordances"), drives, strict=False))
    return train_primary(of or lesson(), IMITATED, columns, drives[3], told, **more)


@pytest.fixture(scope="module")
def drives() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A bright bar on a dark ground: the steering is where it is, it brakes where it is wide."""
    rng = np.random.default_rng(0)
    images = rng.integers(0, 60, (FRAMES, 72, 160, 3), dtype=np.uint8)
    columns = rng.integers(10, 150, FRAMES)
    wide = rng.random(FRAMES) < 0.3
    for image, column, is_wide in zip(images, columns, wide, strict=True):
        half = 8 if is_wide else 3
        image[:, column - half : column + half] = 255
    actions = np.stack([(columns - 80) / 80, wide], 1).astype(np.float32)
    affordances = np.zeros((FRAMES, 10), np.float32)
    affordances[:, 0] = columns > 80
    affordances[:, 5:8] = 60
    affordances[:, 8] = actions[:, 0] / 2
    return images, actions, affordances, np.arange(FRAMES) // 12


@pytest.fixture(scope="module")
def trained(drives):
    torch.set_num_threads(1)
    return train(drives, settings())


def test_the_primary_learns_to_read_the_steering(drives, trained):
    images, actions, _, _ = drives
    network, metrics = trained
    assert not network.training
    assert metrics["samples"] == FRAMES * 5
    assert metrics["validation_steering"] < 0.2 * actions[:, 0].var()
    assert {f"validation_{part}" for part in ("loss", "brake", "indicators")} <= set(metrics)
    proposed, _ = propose(network, {CAMERA: images})
    assert steering(proposed, actions).mean() < 0.2 * actions[:, 0].var()


def test_the_metrics_are_told_after_each_epoch(drives):
    told = []
    _, metrics = train(
        drives,
        settings(samples=500),
        on_epoch=lambda epoch, epochs, metrics: told.append((epoch, epochs, metrics)),
    )
    assert [(epoch, epochs) for epoch, epochs, _ in told] == [(1, 3), (2, 3), (3, 3)]
    assert told[-1][2]["loss"] < told[0][2]["loss"]
    assert metrics == told[-1][2] and metrics["samples"] == 500
    assert [told_metrics["samples"] for *_, told_metrics in told] == [192, 384, 500]


@pytest.mark.parametrize("bfloat16", [True, False])
def test_the_same_seed_gives_the_same_bytes(drives, bfloat16):
    def weights(seed: int) -> list[bytes]:
        told = settings(samples=64, bfloat16=bfloat16, seed=seed)
        network, _ = train(drives, told, lesson(jitter=0.2, mirror=True))
        return [weight.detach().numpy().tobytes() for weight in network.parameters()]

    state = torch.get_rng_state()
    first = weights(0)
    torch.manual_seed(123)
    assert weights(0) == first
    assert weights(1) != first
    torch.set_rng_state(state)


def test_a_warm_start_begins_where_the_last_ended(drives, trained):
    network, _ = trained
    initial = network.state_dict()
    told = settings(samples=1, learning_rate=1e-12, weight_decay=0.0, validation=0.0)
    continued, metrics = train(drives, told, initial=initial)
    for name, weight in continued.state_dict().items():
        assert torch.allclose(weight, initial[name], atol=1e-9)
    assert "validation_loss" not in metrics


def test_a_warm_start_from_another_width_is_refused(drives, trained):
    with pytest.raises(ValueError, match="initial does not fit a primary of 8 channels") as caught:
        train(drives, settings(), lesson(channels=8), initial=trained[0].state_dict())
    assert "\n" not in str(caught.value)


def test_the_papers_sgd_learns_too(drives):
    told_sgd = settings(optimizer="sgd", learning_rate=0.005, weight_decay=0.001)
    losses = []
    train(drives, told_sgd, on_epoch=lambda *told: losses.append(told[2]["loss"]))
    assert losses[-1] < 0.7 * losses[0]


@pytest.mark.parametrize(
    ("position", "wrong", "words"),
    [
        (0, np.zeros((4, 72, 160, 3), np.float32), f"{CAMERA} is float32"),
        (0, np.zeros((4, 160, 72, 3), np.uint8), r"expected uint8 \(4, 72, 160, 3\)"),
        (1, np.zeros((4, 3), np.float32), r"action is float32 \(4, 3\)"),
        (2, np.zeros((3, 10), np.float32), r"affordances is float32 \(3, 10\)"),
        (3, np.zeros(4), "episode_index is float64"),
    ],
)
def test_arrays_of_another_kind_are_refused(position, wrong, words):
    arrays = [
        np.zeros((4, 72, 160, 3), np.uint8),
        np.zeros((4, 2), np.float32),
        np.zeros((4, 10), np.float32),
        np.arange(4),
    ]
    arrays[position] = wrong
    with pytest.raises(ValueError, match=words):
        train(arrays, settings())


def test_nothing_cannot_be_learned_from():
    arrays = (np.zeros((0, 5), np.float16), np.zeros(0), np.zeros(0, int))
    with pytest.raises(ValueError, match=r"features is float16 \(0, 5\), expected floating \(1, 5"):
        train_safety(*arrays, safety_settings())


def safety_settings(**fields) -> SafetySettings:
    given = {
        "optimizer": "adamw",
        "learning_rate": 1e-2,
        "weight_decay": 0.01,
        "samples": 16_000,
        "hidden": 8,
        "validation": 0.1,
        "balance": 0.0,
        "threads": 1,
    }
    return SafetySettings(**given | fields)


@pytest.fixture(scope="module")
def overlapping() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Features float16, deviations and episodes: a fifth is unsafe, and hard to tell."""
    rng = np.random.default_rng(0)
    epsilon = np.where(rng.random(2000) < 0.2, 1.0, 0.0)
    features = rng.normal(size=(2000, 12))
    features[:, 0] += 1.5 * epsilon
    return features.astype(np.float16), epsilon, np.arange(2000) // 50


def recall(overlapping, balance: float, unsafe_counts: float = 1) -> float:
    features, epsilon, episodes = overlapping
    safe = safe_labels(epsilon, 0.0025)
    weight = np.where(safe, 1.0, unsafe_counts)
    network, _ = train_safety(
        features, epsilon, episodes, safety_settings(balance=balance), weight=weight
    )
    safe_probability = safe_probabilities(network, features)
    assert (safe_probability.dtype, safe_probability.shape) == (np.float32, safe.shape)
    # Eq. 2: index 1 is safe, so what looks safe is likelier to be.
    assert safe_probability[safe].mean() > safe_probability[~safe].mean() + 0.1
    return float(np.mean(safe_probability[~safe] < 0.5))


def test_class_weights_raise_the_recall_of_unsafe_frames(overlapping):
    torch.set_num_threads(1)
    without, half, balanced = (recall(overlapping, balance) for balance in (0.0, 0.5, 1.0))
    assert without + 0.1 < half < balanced - 0.05


def test_a_frame_that_stands_for_others_counts_as_much(overlapping):
    assert recall(overlapping, 0.0) + 0.2 < recall(overlapping, 0.0, unsafe_counts=4.0)


def test_class_weights_by_hand():
    safe = np.array([True, True, True, False])
    assert class_weights(safe, 0).tolist() == [1, 1]
    assert class_weights(safe, 1).tolist() == pytest.approx([2, 2 / 3])
    half = class_weights(safe, 0.5)
    assert (half[0] / half[1]).item() == pytest.approx(3**0.5)
    assert (half[0] + 3 * half[1]).item() == pytest.approx(4)
    assert class_weights(np.ones(3, bool), 1).tolist() == [1, 1]
    weighted = class_weights(np.array([True, False]), 0.5, np.array([3.0, 1.0]))
    assert weighted.tolist() == half.tolist()


def test_the_safety_policys_loss_falls_and_its_bytes_are_the_same_again(overlapping):
    losses = []
    network, metrics = train_safety(
        *overlapping, safety_settings(), on_epoch=lambda *told: losses.append(told[2]["loss"])
    )
    assert losses[-1] < losses[0]
    assert metrics["validation_loss"] < np.log(2)
    again, _ = train_safety(*overlapping, safety_settings())
    for weight, other in zip(network.parameters(), again.parameters(), strict=True):
        assert torch.equal(weight, other)


def test_a_safety_policy_that_learns_the_size_says_half_where_it_expects_tau():
    """What it reads is the logarithm: it can be told exactly, and beyond `EXTREME` not at all."""
    rng = np.random.default_rng(0)
    logs = rng.uniform(-4, 4, 2000)
    features = np.stack([logs, rng.normal(size=2000)], 1).astype(np.float32)
    episodes = np.arange(2000) // 50
    told = safety_settings(learns="size", tau=0.01, hidden=32)
    network, metrics = train_safety(features, 0.01 * np.exp(logs), episodes, told)
    assert metrics["validation_loss"] < 0.05
    expected = 1 / (1 + np.exp(logs))  # tau / (tau + deviation)
    assert safe_probabilities(network, features) == pytest.approx(expected, abs=0.15)
    sizes = log_sizes(np.array([0, 0.01, 0.01 * np.e, 1e9]), 0.01)
    assert sizes.tolist() == pytest.approx([-EXTREME, 0, 1, EXTREME])


def test_a_training_begins_without_what_it_does_not_use():
    """SciPy, a computer algebra: a second each, in every process that has a network or trains one."""
    code = """
import sys
import numpy as np, torch
from pipeline.driving.features import IMITATED, CAMERA
from pipeline.driving.lesson import DrivingLesson
from pipeline.policies.network import SafetyNetwork
lesson, state = DrivingLesson(channels=4), torch.get_rng_state()
network = lesson.network(IMITATED, {}, torch.Generator())
SafetyNetwork(network.feature_size, 8, generator=torch.Generator())
batch = {"action": torch.zeros(1, 2), "affordances": torch.zeros(1, 10)}
lesson.loss(network, network.features(torch.zeros(1, 3, 72, 160)), batch)
assert torch.equal(torch.get_rng_state(), state)
print(*sorted({"scipy", "sympy", "pandas", "lerobot"} & sys.modules.keys()))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"
