"""A safety policy's probabilities become shares."""

import numpy as np
import pytest
import torch

from pipeline.learning.calibration import FLATTEST, calibrate
from pipeline.learning.quality import detection_quality
from pipeline.learning.training import safe_probabilities
from pipeline.policies.network import SafetyNetwork


def network() -> SafetyNetwork:
    return SafetyNetwork(3, 8, generator=torch.Generator().manual_seed(0))


def frames(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Features, and whether frames are safe: by chance, as a steeper policy of fewer unsafe says."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(count, 3)).astype(np.float32)
    with torch.inference_mode():
        logits = network()(torch.from_numpy(features)).numpy()
    truth = 1 / (1 + np.exp(-(20 * (logits[:, 1] - logits[:, 0]) + 1)))
    return features, rng.random(count) < truth


def test_a_calibrated_policy_is_as_sure_as_it_is_right() -> None:
    policy = network()
    slope, shift = calibrate(policy, *frames(4000, 1))
    assert (slope, shift) == (pytest.approx(20, rel=0.15), pytest.approx(1, abs=0.15))
    features, safe = frames(4000, 2)
    before, after = (
        detection_quality(safe_probabilities(each, features), 1.0 - safe, 0.5, 0.5)
        for each in (network(), policy)
    )
    assert before["calibration_error"] > 0.15
    assert after["calibration_error"] < 0.04
    assert after["auroc"] == pytest.approx(before["auroc"])


def test_a_calibration_never_turns_the_order_around() -> None:
    policy = network()
    features, safe = frames(400, 1)
    slope, _ = calibrate(policy, features, ~safe)
    assert slope == FLATTEST


def test_a_few_frames_that_are_all_safe_leave_some_doubt() -> None:
    policy = network()
    features, _ = frames(8, 1)
    calibrate(policy, features, np.ones(8, bool))
    assert safe_probabilities(policy, features) == pytest.approx(0.9, abs=0.01)


def test_nothing_calibrates_nothing() -> None:
    with pytest.raises(ValueError, match="no frames to calibrate with"):
        calibrate(network(), np.zeros((0, 3), np.float32), np.zeros(0, bool))
