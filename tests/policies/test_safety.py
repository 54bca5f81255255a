"""The safety policy as a LeRobot policy, and its polarity."""

from pathlib import Path

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from lerobot.policies.factory import get_policy_class, make_pre_post_processors

from pipeline.driving.features import CAMERA
from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.policy import PrimaryConfig, PrimaryPolicy
from pipeline.policies.inference import Driver
from pipeline.policies.loading import weights_sha256
from pipeline.policies.network import SafetyNetwork
from pipeline.policies.safety import FEATURES, SafetyConfig, SafetyPolicy

torch.set_num_threads(1)

SIZE = PrimaryNetwork(2).feature_size


def make(**fields) -> SafetyPolicy:
    network = SafetyNetwork(SIZE, 8, generator=torch.Generator().manual_seed(0))
    return SafetyPolicy(SafetyConfig(features=SIZE, hidden=8, **fields), network)


def biased(towards_safe: float, **fields) -> SafetyPolicy:
    policy = make(**fields)
    with torch.no_grad():
        policy.network.layers[-1].weight.zero_()
        policy.network.layers[-1].bias.copy_(torch.tensor([0.0, towards_safe]))
    return policy


def test_one_is_safe_and_zero_is_unsafe():
    batch = {FEATURES: torch.rand(3, SIZE)}
    assert biased(+4).safe_probability(batch[FEATURES]).min() > 0.9
    assert biased(+4).select_action(batch).tolist() == [[1.0]] * 3
    assert biased(-4).safe_probability(batch[FEATURES]).max() < 0.1
    assert biased(-4).predict_action_chunk(batch).tolist() == [[[0.0]]] * 3


def test_the_loss_is_equation_4():
    policy = make()
    conv5, safe = torch.rand(4, SIZE), torch.tensor([[1.0], [0.0], [0.0], [1.0]])
    loss, _ = policy.forward({FEATURES: conv5, "action": safe})
    p = policy.safe_probability(conv5)
    assert loss.item() == pytest.approx(F.binary_cross_entropy(p, safe[:, 0]).item(), rel=1e-5)


def test_it_is_loaded_as_it_was_saved_with_the_rule_of_its_labels(tmp_path: Path):
    policy = make(tau=0.01, cut=0.4, horizon=1.0, horizon_mode="max", measure="steering")
    policy.save_pretrained(tmp_path / "safety_0")
    again = SafetyPolicy.from_pretrained(tmp_path / "safety_0")
    assert again.config == policy.config
    for weights, loaded in zip(policy.parameters(), again.parameters(), strict=True):
        assert torch.equal(weights, loaded)
    again.save_pretrained(tmp_path / "again")
    for path in (tmp_path / "safety_0").iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()


def test_the_driver_takes_it_with_its_own_primary_alone(tmp_path: Path):
    for seed, name in enumerate(("primary_0", "primary_1")):
        primary = PrimaryNetwork(2, generator=torch.Generator().manual_seed(seed))
        PrimaryPolicy(PrimaryConfig(channels=2), primary).save_pretrained(tmp_path / name)
    watched = weights_sha256(tmp_path / "primary_0")
    biased(-4, primary_sha256=watched).save_pretrained(tmp_path / "safety_0")
    driver = Driver.load(tmp_path / "primary_0", tmp_path / "safety_0")
    image = np.random.default_rng(0).integers(0, 256, (72, 160, 3), np.uint8)
    assert driver.act({CAMERA: image})[1]["safe_probability"] < 0.1
    with pytest.raises(ValueError, match="safety_0: was trained to watch another primary than"):
        Driver.load(tmp_path / "primary_1", tmp_path / "safety_0")


def test_a_primary_is_no_safety_policy(tmp_path: Path):
    make().save_pretrained(tmp_path)
    with pytest.raises(ValueError, match="type is 'safedagger_safety', expected 'safedagger_prim"):
        PrimaryPolicy.from_pretrained(tmp_path)


def test_lerobots_tools_find_and_run_it():
    policy = make()
    assert get_policy_class("safedagger_safety") is SafetyPolicy
    before, after = make_pre_post_processors(policy.config)
    assert after(policy.select_action(before({FEATURES: torch.rand(3, SIZE)}))).shape == (3, 1)


@pytest.mark.parametrize("name", ["tau", "cut", "horizon", "balance"])
@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
def test_numbers_out_of_range_are_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} is {value}, expected"):
        make(**{name: value})


def test_a_network_of_another_size_is_refused():
    with pytest.raises(ValueError, match=r"network has \(160, 4\) inputs and hidden units"):
        SafetyPolicy(SafetyConfig(features=SIZE, hidden=8), SafetyNetwork(SIZE, 4))
