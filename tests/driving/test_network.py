"""The networks against the paper's table, layer by layer."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from pipeline.driving.features import ACTIONS, AFFORDANCES
from pipeline.driving.network import (
    DISTANCES,
    INDICATORS,
    POSITIONS,
    LossWeights,
    PrimaryNetwork,
    primary_loss,
    to_actions,
)
from pipeline.policies.computing import CPU
from pipeline.policies.network import SafetyNetwork, has_bfloat16, to_float

torch.set_num_threads(1)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_the_layers_are_those_of_the_papers_table():
    network = PrimaryNetwork(64, generator=generator())
    shapes = {}
    for name in ("conv1", "conv2", "conv3", "conv4", "conv5"):
        layer = getattr(network, name)
        layer.register_forward_hook(
            lambda layer, _, output, name=name: shapes.update(
                {name: (tuple(layer.kernel_size), tuple(output.shape[1:]))}
            )
        )

    features = network.features(torch.rand(2, 3, 72, 160))

    assert shapes == {
        "conv1": ((3, 3), (64, 72, 160)),
        "conv2": ((3, 3), (64, 36, 80)),
        "conv3": ((3, 3), (64, 18, 40)),
        "conv4": ((3, 3), (64, 9, 20)),
        "conv5": ((5, 5), (128, 4, 10)),
    }
    assert features.shape == (2, 128, 4, 10)
    assert PrimaryNetwork(64).feature_size == 128 * 4 * 10 == 5120


def test_the_heads_are_those_of_the_papers_table():
    network = PrimaryNetwork(64, generator=generator())

    def parameters(module: torch.nn.Module) -> int:
        return sum(weight.numel() for weight in module.parameters())

    heads = {name: parameters(head) for name, head in network.outputs.items()}
    assert heads == {
        **dict.fromkeys((*INDICATORS, "brake"), 5120 * 2 + 2),
        **dict.fromkeys((*DISTANCES, *POSITIONS), 5120 + 1),
        "steering": 5120 * 64 + 64 + 64 + 1,
    }
    convolutions = [parameters(layer) for layer in network.convolutions()]
    assert convolutions == [1792, 36928, 36928, 36928, 204928]
    assert parameters(network) == sum(convolutions) + sum(heads.values()) == 732_370


def test_outputs_are_logits_for_the_flags_and_numbers_for_the_rest():
    network = PrimaryNetwork(2, generator=generator())
    outputs = network(torch.rand(3, 3, 72, 160))
    assert set(outputs) == {*AFFORDANCES, *ACTIONS}
    for name, output in outputs.items():
        assert output.shape == ((3, 2) if name in (*INDICATORS, "brake") else (3,))
    steering, brake = network.action_heads(network.features(torch.rand(1, 3, 72, 160)))
    assert (steering.shape, brake.shape) == ((1,), (1, 2))


BFLOAT16 = pytest.mark.skipif(not has_bfloat16(CPU), reason="this processor has no bfloat16")


@pytest.mark.parametrize(
    ("dtype", "close"),
    [(torch.float32, 1e-3), pytest.param(torch.bfloat16, 0, marks=BFLOAT16)],
    ids=["float32", "bfloat16"],
)
def test_pooling_before_the_rectifier_changes_neither_values_nor_gradients(
    dtype: torch.dtype, close: float
):
    """In float32 the gradients' last bits; in bfloat16, where oneDNN lays it out, not one bit."""
    network = PrimaryNetwork(8, generator=generator())
    images = torch.rand(2, 3, 72, 160, generator=generator(1)).to(memory_format=torch.channels_last)

    def as_in_the_paper() -> torch.Tensor:
        x = (2 * images - 1).to(dtype)
        for convolution in network.convolutions()[:4]:
            x = F.max_pool2d(F.relu(convolution(x)), 2)
        return F.relu(network.conv5(x))

    gradients = []
    for features in (network.features(images, dtype), as_in_the_paper()):
        network.zero_grad()
        assert features.dtype == dtype
        features.square().sum().backward()
        gradients.append([layer.weight.grad.clone() for layer in network.convolutions()])
        assert torch.equal(features, as_in_the_paper())
    for one, other in zip(*gradients, strict=True):
        torch.testing.assert_close(one, other, rtol=close, atol=close)


def test_weights_come_from_the_generator_and_leave_the_global_one_alone():
    before = torch.get_rng_state()
    first, again, other = (PrimaryNetwork(2, generator=generator(seed)) for seed in (3, 3, 4))
    assert torch.equal(before, torch.get_rng_state())
    assert torch.equal(first.conv1.weight, again.conv1.weight)
    assert not torch.equal(first.conv1.weight, other.conv1.weight)


@pytest.mark.parametrize("make", [lambda: PrimaryNetwork(0), lambda: SafetyNetwork(5, 0)])
def test_widths_must_be_positive(make):
    with pytest.raises(ValueError, match="expected at least 1"):
        make()


def test_the_safety_network_has_two_hidden_layers_and_two_logits():
    network = SafetyNetwork(160, 8, generator=generator())
    linear = [layer for layer in network.layers if isinstance(layer, torch.nn.Linear)]
    assert [(layer.in_features, layer.out_features) for layer in linear] == [
        (160, 8),
        (8, 8),
        (8, 2),
    ]
    conv5 = torch.rand(3, 4, 4, 10)
    assert torch.equal(network(conv5), network(conv5.flatten(1)))


def test_what_the_safety_network_learns_never_reaches_the_primary():
    primary = PrimaryNetwork(2, generator=generator())
    safety = SafetyNetwork(PrimaryNetwork(2).feature_size, 8, generator=generator())
    features = primary.features(torch.rand(2, 3, 72, 160))
    assert features.requires_grad

    F.cross_entropy(safety(features), torch.tensor([0, 1])).backward()

    assert all(weight.grad is not None for weight in safety.parameters())
    assert all(weight.grad is None for weight in primary.parameters())


def test_the_loss_by_hand():
    flag = torch.tensor([[0.0, 0.0]])  # cross-entropy log 2, whatever the label
    outputs = {
        **dict.fromkeys((*INDICATORS, "brake"), flag),
        **dict.fromkeys(DISTANCES, torch.tensor([0.5])),
        **dict.fromkeys(POSITIONS, torch.tensor([0.1])),
        "steering": torch.tensor([0.3]),
    }
    affordances = torch.tensor([[1.0, 0, 0, 1, 0, 60, 30, 60, 0.1, -0.1]])
    weights = LossWeights(steering=2, brake=3, brake_on=5, indicators=7, distances=11, positions=13)
    actions = torch.tensor([[0.1, 1.0]])

    loss, parts = primary_loss(outputs, actions, affordances, sensor_range=60, weights=weights)

    expected = {
        "steering": 0.04,
        "brake": np.log(2),
        "indicators": np.log(2),
        "distances": (0.25 + 0 + 0.25) / 3,
        "positions": (0 + 0.04) / 2,
    }
    assert {name: part.item() for name, part in parts.items()} == pytest.approx(expected)
    counted = {"steering": 2, "brake": 3, "indicators": 7, "distances": 11, "positions": 13}
    assert loss.item() == pytest.approx(sum(counted[n] * v for n, v in expected.items()))

    _, parts = primary_loss(outputs, actions, None, sensor_range=60, weights=weights)
    assert set(parts) == {"steering", "brake"}


def test_the_brakes_class_weight_counts_the_rare_label_more():
    outputs = {"steering": torch.zeros(2), "brake": torch.tensor([[2.0, 0.0], [2.0, 0.0]])}
    actions = torch.tensor([[0.0, 0.0], [0.0, 1.0]])

    def brake(weight: float) -> float:
        weights = LossWeights(brake_on=weight)
        return primary_loss(outputs, actions, None, sensor_range=1, weights=weights)[1][
            "brake"
        ].item()

    off, on = -np.log(1 / (1 + np.exp(-2.0))), -np.log(1 / (1 + np.exp(2.0)))
    assert brake(1) == pytest.approx((off + on) / 2)
    assert brake(3) == pytest.approx((off + 3 * on) / 4)


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_a_loss_weight_must_be_a_number_from_zero(value):
    with pytest.raises(ValueError, match="loss weight brake is"):
        LossWeights(brake=value)


def test_actions_are_cut_to_their_range():
    brake = torch.tensor([[0.0, 0.0], [0.0, 2.0], [0.0, 3.0]])
    actions = to_actions(torch.tensor([-3.0, 0.25, 1.5]), brake, 0.9)
    assert actions.dtype == torch.float32
    assert actions.tolist() == [[-1, 0], [0.25, 0], [1, 1]]


def test_images_become_floats_with_the_colours_first():
    image = torch.arange(2 * 3 * 3, dtype=torch.uint8).reshape(1, 2, 3, 3)
    converted = to_float(image)
    assert converted.shape == (1, 3, 2, 3)
    assert converted[0, 1, 1, 2] == image[0, 1, 2, 1] / 255
    assert to_float(torch.full((1, 2, 2, 3), 255, dtype=torch.uint8)).max() == 1
