"""The primary as a LeRobot policy: saved, loaded strictly, and run by LeRobot's tools."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from lerobot.policies.factory import get_policy_class, make_policy, make_pre_post_processors
from safetensors.torch import load_file, save_file

from pipeline.driving.features import CAMERA, FEATURES
from pipeline.driving.network import LossWeights, PrimaryNetwork
from pipeline.driving.policy import PrimaryConfig, PrimaryPolicy
from pipeline.policies.inference import Driver
from pipeline.policies.loading import load_primary
from tests.files import rewrite, tree

torch.set_num_threads(1)

Damage = Callable[[Path], object]
FILES = {
    "config.json",
    "model.safetensors",
    "policy_preprocessor.json",
    "policy_postprocessor.json",
}


def make(**fields) -> PrimaryPolicy:
    network = PrimaryNetwork(4, generator=torch.Generator().manual_seed(0))
    return PrimaryPolicy(PrimaryConfig(channels=4, **fields), network)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    make(brake_cut=0.6, loss=LossWeights(steering=7.0)).save_pretrained(tmp_path / "primary_0")
    return tmp_path / "primary_0"


def test_it_is_loaded_as_it_was_saved(saved, capsys):
    policy = PrimaryPolicy.from_pretrained(saved)
    assert policy.config == make(brake_cut=0.6, loss=LossWeights(steering=7.0)).config
    assert not policy.training
    for weights, again in zip(make().parameters(), policy.parameters(), strict=True):
        assert torch.equal(weights, again)
    assert capsys.readouterr().out == ""
    assert (policy.config.device, policy.config.push_to_hub) == ("cpu", False)
    assert set(tree(saved)) == FILES
    policy.save_pretrained(saved.with_name("again"))
    assert tree(saved) == tree(saved.with_name("again"))


def test_it_acts_as_the_driver_does(saved):
    image = np.random.default_rng(0).integers(0, 256, (72, 160, 3), dtype=np.uint8)
    policy = PrimaryPolicy.from_pretrained(saved)
    driver = Driver(load_primary(saved), bfloat16=False)
    assert driver.primary.brake_cut == 0.6
    batch = {CAMERA: torch.from_numpy(image).permute(2, 0, 1)[None] / 255}
    action = policy.select_action(batch)
    assert (action.dtype, action.shape) == (torch.float32, (1, 2))
    assert action[0].numpy() == pytest.approx(driver.act({CAMERA: image})[0], abs=1e-5)
    assert torch.equal(policy.predict_action_chunk(batch), action[:, None])


def test_the_affordances_are_further_targets():
    policy = make(loss=LossWeights(steering=2.0, brake=1.0))
    batch = {CAMERA: torch.rand(2, 3, 72, 160), "action": torch.tensor([[0.1, 0], [-0.2, 1.0]])}
    loss, parts = policy.forward(batch)
    assert loss.item() == pytest.approx(2 * parts["steering"] + parts["brake"], rel=1e-5)
    loss, parts = policy.forward(batch | {"affordances": torch.zeros(2, 10)})
    assert set(parts) == {"steering", "brake", "indicators", "distances", "positions"}
    loss.backward()
    assert all(weight.grad is not None for weight in policy.get_optim_params())


def test_lerobots_tools_find_make_and_run_it(saved):
    assert get_policy_class("safedagger_primary") is PrimaryPolicy
    config = PrimaryConfig(channels=4, pretrained_path=saved)
    features = {
        name: feature | {"shape": tuple(feature["shape"])} for name, feature in FEATURES.items()
    }
    policy = make_policy(config, ds_meta=SimpleNamespace(features=features, stats=None))
    assert isinstance(policy, PrimaryPolicy)
    for path in (str(saved), None):
        before, after = make_pre_post_processors(config, pretrained_path=path)
        action = after(policy.select_action(before({CAMERA: torch.rand(3, 72, 160)})))
        assert action.shape == (1, 2)


def told(**fields) -> Damage:
    """Fields of config.json that say something else."""
    return lambda directory: rewrite(directory / "config.json", **fields)


def weighed(change: Callable[[dict], dict]) -> Damage:
    """Other weights."""

    def save(directory: Path) -> None:
        path = directory / "model.safetensors"
        save_file(change(load_file(path)), path)

    return save


def without(weights: dict, name: str) -> dict:
    return {other: values for other, values in weights.items() if other != name}


def cut_short(directory: Path) -> None:
    path = directory / "model.safetensors"
    path.write_bytes(path.read_bytes()[:-100])


@pytest.mark.parametrize(
    ("damage", "words", "driven"),
    [
        (lambda d: (d / "config.json").unlink(), "config.json: No such file or directory", True),
        (lambda d: (d / "config.json").write_text("{\n\n"), "config.json: not JSON", True),
        (told(type="act"), "the policy's type is 'act', expected 'safedagger_primary'", False),
        (
            told(channels=8),
            r"conv1.bias is torch.float32 \[4\], expected torch.float32 \[8\]",
            True,
        ),
        (told(channels="wide"), "channels", True),
        (told(colour="red"), "colour", False),
        (told(brake_cut=1.5), "brake_cut is 1.5", False),
        (lambda d: (d / "model.safetensors").unlink(), "model.safetensors is missing, exp", True),
        (cut_short, "model.safetensors: .* expected the weights of a policy", True),
        (
            weighed(lambda weights: without(weights, "network.conv3.bias")),
            "network.conv3.bias is none, expected torch.float32",
            True,
        ),
        (
            weighed(lambda weights: weights | {"extra": torch.zeros(1)}),
            "extra is torch.float32 .* expected none",
            True,
        ),
    ],
)
def test_what_does_not_fit_is_one_line(saved, damage: Damage, words: str, driven: bool):
    """And some of it to whoever drives without LeRobot."""
    damage(saved)
    for load in (PrimaryPolicy.from_pretrained, *([Driver.load] if driven else [])):
        with pytest.raises(ValueError, match=words) as caught:
            load(saved)
        assert "\n" not in str(caught.value)
        assert str(saved) in str(caught.value)


def test_a_network_of_another_width_is_refused():
    with pytest.raises(ValueError, match="network has 2 channels, expected 4"):
        PrimaryPolicy(PrimaryConfig(channels=4), PrimaryNetwork(2))


def test_other_features_are_refused():
    config = PrimaryConfig(channels=4, input_features={})
    with pytest.raises(ValueError, match=r"input_features is \{\}, expected \{'observation"):
        PrimaryPolicy(config)
