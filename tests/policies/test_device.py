"""Where networks compute: by name, and with the same result but for rounding."""

from pathlib import Path

import cloudpickle
import numpy as np
import pytest
import torch
from torch import nn

from pipeline.learning.settings import Optimisation, SafetySettings
from pipeline.learning.training import train_primary, train_safety
from pipeline.policies.computing import find_device
from pipeline.policies.conv import ConvLesson
from pipeline.policies.inference import Driver, propose
from pipeline.policies.loading import load_primary
from tests.devices import DEVICES
from tests.policies.test_conv import FEATURES

FRAMES = 64
FIT = {
    **{"optimizer": "sgd", "learning_rate": 1e-3, "weight_decay": 0.0, "batch": 16},
    **{"samples": 2 * FRAMES, "validation": 0.25, "threads": 1, "bfloat16": False},
}
CLOSE = {"rtol": 0.01, "atol": 0.01}  # a GPU rounds the numbers that it multiplies


@pytest.mark.parametrize("name", ["nothing", "", "meta", "cuda:99", "CPU"])
def test_a_device_that_there_is_not_is_one_line(name: str) -> None:
    with pytest.raises(ValueError) as caught:
        find_device(name)
    expected = f"device is {name!r}, expected one that this machine has: cpu"
    assert str(caught.value).startswith(expected)
    assert "\n" not in str(caught.value)


def close(network: nn.Module, other: nn.Module) -> bool:
    """Whether two networks on the processor have nearly the same weights."""
    pairs = zip(network.state_dict().values(), other.state_dict().values(), strict=True)
    return all(torch.allclose(one, another, **CLOSE) for one, another in pairs)


@pytest.mark.parametrize("name", DEVICES)
def test_training_and_driving_come_to_the_same_on_each(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    columns = {
        "observation.image": rng.integers(0, 256, (FRAMES, 32, 48, 3), dtype=np.uint8),
        "observation.state": rng.random((FRAMES, 2), np.float32),
        "action": rng.random((FRAMES, 2), np.float32),
    }
    lesson, episodes = ConvLesson(channels=4, hidden=8, jitter=0.2), np.arange(FRAMES) // 4
    features = lesson.learned(FEATURES)
    (expected, measured), (network, again) = (
        train_primary(lesson, features, columns, episodes, Optimisation(**FIT), device=device)
        for device in (find_device("cpu"), find_device(name))
    )
    assert network.device.type == "cpu" and close(network, expected)
    assert again == pytest.approx(measured, rel=0.01)

    lesson.policy(network).save_pretrained(tmp_path)
    (_, looked), (proposed, features_there) = (
        propose(load_primary(tmp_path, device=find_device(each)), columns) for each in ("cpu", name)
    )
    np.testing.assert_allclose(features_there, looked, **CLOSE)
    (watched, _), (safety, _) = (
        train_safety(
            looked,
            columns["action"][:, 0] / 200,
            episodes,
            SafetySettings(**FIT, hidden=4, balance=1),
            device=device,
        )
        for device in (find_device("cpu"), find_device(name))
    )
    assert close(safety, watched)

    drivers = [
        Driver(load_primary(tmp_path, device=find_device(each)), safety) for each in ("cpu", name)
    ]
    drivers.append(cloudpickle.loads(cloudpickle.dumps(drivers[1])))  # as it is sent to a worker
    assert {driver.primary.device.type for driver in drivers} == {"cpu", name}
    for frame in range(4):
        seen = {column: columns[column][frame] for column in network.seen}
        (action, signals), *others = (driver.act(seen) for driver in drivers)
        np.testing.assert_allclose(action, proposed[frame], **CLOSE)
        for there, signals_there in others:
            np.testing.assert_allclose(there, action, **CLOSE)
            assert signals_there == pytest.approx(signals, abs=0.01)
