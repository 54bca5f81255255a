"""The primary for any robot: it learns, is saved, and is the same to LeRobot."""

from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.policies.factory import get_policy_class

from pipeline.data.schema import Feature
from pipeline.learning.settings import Optimisation
from pipeline.learning.training import train_primary
from pipeline.policies.conv import ConvActor, ConvLesson
from pipeline.policies.conv_policy import ConvPolicy
from pipeline.policies.inference import Driver, propose
from pipeline.policies.loading import load_primary
from pipeline.policies.network import SafetyNetwork

FRAMES = 200
IMAGE: Feature = {"dtype": "image", "shape": (32, 48, 3), "names": ["height", "width", "channel"]}
NUMBERS: Feature = {"dtype": "float32", "shape": (2,), "names": ["a", "b"]}
FEATURES = {"observation.image": IMAGE, "observation.state": NUMBERS, "action": NUMBERS}


@pytest.fixture(scope="module")
def columns() -> dict[str, np.ndarray]:
    """A bright bar: the first number of the action is where it is, the second is in the state."""
    rng = np.random.default_rng(0)
    images = rng.integers(0, 60, (FRAMES, 32, 48, 3), dtype=np.uint8)
    places = rng.integers(4, 44, FRAMES)
    for image, place in zip(images, places, strict=True):
        image[:, place - 2 : place + 2] = 255
    state = rng.normal(50, 20, (FRAMES, 2)).astype(np.float32)
    action = np.stack([places / 4, 1000 + state[:, 1]], 1).astype(np.float32)
    return {"observation.image": images, "observation.state": state, "action": action}


def trained(columns: dict[str, np.ndarray], **fields: int) -> ConvActor:
    told = {"optimizer": "adamw", "learning_rate": 3e-3, "weight_decay": 0.0, "batch": 16}
    settings = Optimisation(**told, samples=FRAMES * 12, validation=0.0, threads=1, **fields)
    lesson = ConvLesson(channels=8, hidden=32)
    features = lesson.learned(FEATURES)
    network, _ = train_primary(lesson, features, columns, np.arange(FRAMES), settings)
    return network


@pytest.fixture(scope="module")
def network(columns: dict[str, np.ndarray]) -> ConvActor:
    torch.set_num_threads(1)
    return trained(columns)


def test_it_learns_from_the_image_and_from_the_state(
    network: ConvActor, columns: dict[str, np.ndarray]
) -> None:
    proposed, looked = propose(network, columns)
    apart = ((proposed - columns["action"]) ** 2).mean(axis=0) / columns["action"].var(axis=0)
    assert (apart < 0.1).all()
    assert looked.shape == (FRAMES, network.feature_size) == (FRAMES, 16 * 2 * 3 + 2)


def test_the_same_seed_gives_the_same_bytes(
    network: ConvActor, columns: dict[str, np.ndarray]
) -> None:
    again = trained(columns).state_dict()
    for name, weights in network.state_dict().items():
        assert torch.equal(weights, again[name])


def test_saved_it_is_the_same_here_and_to_lerobot(
    network: ConvActor, columns: dict[str, np.ndarray], tmp_path: Path
) -> None:
    ConvLesson().policy(network).save_pretrained(tmp_path)
    loaded = load_primary(tmp_path)
    seen = {name: columns[name][7] for name in network.seen}
    action, _ = Driver(loaded, bfloat16=False).act(seen)
    np.testing.assert_array_equal(action, Driver(network, bfloat16=False).act(seen)[0])
    assert loaded.feature_size == network.feature_size
    assert get_policy_class("safedagger_conv") is ConvPolicy
    policy = ConvPolicy.from_pretrained(tmp_path)
    batch = {
        "observation.image": torch.from_numpy(seen["observation.image"]).permute(2, 0, 1)[None]
        / 255,
        "observation.state": torch.from_numpy(seen["observation.state"])[None],
    }
    np.testing.assert_allclose(policy.select_action(batch)[0].numpy(), action, rtol=1e-5)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    policy.save_pretrained(tmp_path / "again")
    assert before == {file.name: file.read_bytes() for file in (tmp_path / "again").iterdir()}


def test_a_safety_policy_reads_what_it_looked_at(
    network: ConvActor, columns: dict[str, np.ndarray]
) -> None:
    driver = Driver(network, SafetyNetwork(network.feature_size, 4))
    _, signals = driver.act({name: columns[name][0] for name in network.seen})
    assert 0 <= signals["safe_probability"] <= 1
    with pytest.raises(ValueError, match="safety takes 7 numbers, expected the 98"):
        Driver(network, SafetyNetwork(7, 4))


def test_what_it_cannot_see_is_named(network: ConvActor, columns: dict[str, np.ndarray]) -> None:
    with pytest.raises(ValueError, match=r"observation\.state is missing, expected float32"):
        Driver(network).act({"observation.image": columns["observation.image"][0]})
    two = FEATURES | {"observation.images.wrist": IMAGE}
    with pytest.raises(ValueError, match=r"cameras are observation\.image, observation\.im"):
        ConvLesson().learned(two)
    with pytest.raises(ValueError, match="cameras are none, expected a single one"):
        ConvLesson().learned({"action": NUMBERS})


def test_an_image_alone_will_do(columns: dict[str, np.ndarray]) -> None:
    features = ConvLesson().learned({n: FEATURES[n] for n in ("observation.image", "action")})
    network = ConvLesson().network(features, columns, torch.Generator().manual_seed(0))
    assert network.feature_size == 32 * 2 * 3
    action, _ = Driver(network).act({"observation.image": columns["observation.image"][0]})
    assert action.shape == (2,)
