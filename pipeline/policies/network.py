"""The networks of the primary and the safety policy (Appendix B), in plain PyTorch.

In the shapes, B is the number of images and c the channels of Conv1 to Conv4.
"""

import math
from dataclasses import dataclass, fields

import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch.nn.utils import skip_init

from pipeline.driving.features import ACTIONS, AFFORDANCES, IMAGE_SHAPE

INDICATORS = AFFORDANCES[:5]
DISTANCES = AFFORDANCES[5:8]
POSITIONS = AFFORDANCES[8:]

CHANNELS = 64
"""Channels of Conv1 to Conv4 in the paper; Conv5 has twice as many."""


class PrimaryNetwork(nn.Module):
    """Five convolutions, and one head for each of the ten affordances and two actions.

    Args:
        channels: c, the width of Conv1 to Conv4.
        generator: draws the initial weights; PyTorch's global one where None.

    Raises:
        ValueError: `channels` is not positive.
    """

    def __init__(
        self, channels: int = CHANNELS, *, generator: torch.Generator | None = None
    ) -> None:
        super().__init__()
        if channels < 1:
            raise ValueError(f"channels is {channels}, expected at least 1")
        self.channels = channels
        self.conv1 = _convolution(IMAGE_SHAPE[2], channels, 3)
        self.conv2 = _convolution(channels, channels, 3)
        self.conv3 = _convolution(channels, channels, 3)
        self.conv4 = _convolution(channels, channels, 3)
        self.conv5 = _convolution(channels, 2 * channels, 5)
        flat = feature_size(channels)
        self.outputs = nn.ModuleDict(
            {name: _linear(flat, 2) for name in (*INDICATORS, "brake")}
            | {name: _linear(flat, 1) for name in (*DISTANCES, *POSITIONS)}
            | {"steering": nn.Sequential(_linear(flat, 64), nn.ReLU(), _linear(64, 1))}
        )
        _initialise(self, generator)

    def convolutions(self) -> tuple[nn.Conv2d, ...]:
        """Conv1 to Conv5."""
        return self.conv1, self.conv2, self.conv3, self.conv4, self.conv5

    def features(self, images: Tensor) -> Tensor:
        """Conv5's activations [B, 2c, 4, 10] of `images` [B, 3, 72, 160], float in [0, 1]."""
        # Centred on mid-grey, it learns faster than from positive numbers alone.
        x = images.mul(2).sub_(1).to(self.conv1.weight.dtype)
        for convolution in self.convolutions()[:4]:
            # The rectifier and the maximum commute: after the pooling it has a quarter to do.
            x = F.relu(F.max_pool2d(convolution(x), 2))
        return F.relu(self.conv5(x))

    def heads(self, features: Tensor) -> dict[str, Tensor]:
        """All outputs, one for each of AFFORDANCES and ACTIONS, from `features` [B, 2c, 4, 10].

        The indicators and the brake are logits [B, 2], index 1 being "yes". The others are [B]:
        distances in units of the sensor's range, positions and steering as in the schema.
        """
        flat = features.flatten(1)
        return {name: self._output(name, flat) for name in (*AFFORDANCES, *ACTIONS)}

    def action_heads(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """The two of `heads` that drive: steering [B] and the brake's logits [B, 2]."""
        flat = features.flatten(1)
        return self._output("steering", flat), self._output("brake", flat)

    def forward(self, images: Tensor) -> dict[str, Tensor]:
        """`heads` of the `features` of `images` [B, 3, 72, 160], float in [0, 1]."""
        return self.heads(self.features(images))

    def _output(self, name: str, flat: Tensor) -> Tensor:
        output: Tensor = self.outputs[name](flat)
        return output.squeeze(1) if output.shape[1] == 1 else output


class SafetyNetwork(nn.Module):
    """Two hidden layers on the primary's Conv5; two logits, index 1 being safe (Eq. 2).

    Args:
        in_features: numbers in Conv5's activations of one image: 2c * 4 * 10.
        hidden: width of each of the two hidden layers.
        generator: draws the initial weights; PyTorch's global one where None.

    Raises:
        ValueError: a width is not positive.
    """

    def __init__(
        self, in_features: int, hidden: int, *, generator: torch.Generator | None = None
    ) -> None:
        super().__init__()
        if in_features < 1 or hidden < 1:
            raise ValueError(
                f"in_features is {in_features} and hidden {hidden}, expected at least 1"
            )
        self.in_features, self.hidden = in_features, hidden
        self.layers = nn.Sequential(
            _linear(in_features, hidden),
            nn.ReLU(),
            _linear(hidden, hidden),
            nn.ReLU(),
            _linear(hidden, 2),
        )
        _initialise(self, generator)

    def forward(self, features: Tensor) -> Tensor:
        """Logits [B, 2] of `features` [B, 2c, 4, 10] or [B, in_features] of any float type."""
        # Detached: what the safety policy learns must never change the primary.
        logits: Tensor = self.layers(features.detach().flatten(1).float())
        return logits


@dataclass(frozen=True)
class LossWeights:
    """What each part of the primary's loss counts for; each part is a mean over its outputs.

    Raises:
        ValueError: a weight is negative or not finite.
    """

    steering: float = 20.0
    """Squared error of the steering: small numbers (0.0025 is the paper's threshold)."""
    brake: float = 1.0
    """Cross-entropy of the brake."""
    brake_on: float = 3.0
    """Class weight of the brake being on, the rare label, against 1 for off."""
    indicators: float = 0.5
    """Cross-entropy of the five indicators."""
    distances: float = 1.0
    """Squared error of the three distances, in units of the sensor's range."""
    positions: float = 1.0
    """Squared error of the position in the lane and the angle to it."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(
                    f"loss weight {field.name} is {value}, expected a number of at least 0"
                )


def primary_loss(
    outputs: dict[str, Tensor],
    actions: Tensor,
    affordances: Tensor | None,
    *,
    sensor_range: float,
    weights: LossWeights,
) -> tuple[Tensor, dict[str, Tensor]]:
    """The multi-task loss, and its unweighted parts.

    Args:
        outputs: of `PrimaryNetwork.heads`.
        actions: [B, 2], steering [-1, 1] and brake {0, 1}.
        affordances: [B, 10] as in the schema, distances in metres; None leaves them out.
        sensor_range: the distance that is predicted as 1 [m].
    """
    brake_classes = actions.new_tensor([1.0, weights.brake_on])
    parts = {
        "steering": F.mse_loss(outputs["steering"].float(), actions[:, 0]),
        "brake": F.cross_entropy(outputs["brake"].float(), actions[:, 1].long(), brake_classes),
    }
    if affordances is not None:
        indicators, distances, positions = affordances.split([5, 3, 2], dim=1)
        logits = torch.stack([outputs[name].float() for name in INDICATORS], 1)
        parts["indicators"] = F.cross_entropy(logits.flatten(0, 1), indicators.flatten().long())
        for part, names, targets in (
            ("distances", DISTANCES, distances / sensor_range),
            ("positions", POSITIONS, positions),
        ):
            predicted = torch.stack([outputs[name].float() for name in names], 1)
            parts[part] = F.mse_loss(predicted, targets)
    loss = torch.stack([getattr(weights, name) * part for name, part in parts.items()]).sum()
    return loss, parts


def to_float(images: Tensor) -> Tensor:
    """`images` uint8 [B, H, W, 3] as the network takes them: float [B, 3, H, W] in [0, 1].

    The numbers stay in their order in memory, which PyTorch calls channels_last.
    """
    return images.permute(0, 3, 1, 2).float().div_(255)


def to_actions(steering: Tensor, brake: Tensor, brake_cut: float) -> Tensor:
    """Actions float32 [B, 2] of `action_heads`: steering cut to [-1, 1], brake {0, 1}.

    The brake is on where its probability is above `brake_cut`.
    """
    on = brake.softmax(1)[:, 1] > brake_cut
    return torch.stack([steering.float().clamp(-1, 1), on.float()], 1)


def feature_size(channels: int) -> int:
    """Numbers in Conv5's activations of one image: 2c * 4 * 10, after four poolings by 2."""
    height, width, _ = IMAGE_SHAPE
    return 2 * channels * (height // 16) * (width // 16)


def has_bfloat16() -> bool:
    """Whether this processor computes in bfloat16 itself; emulated, it is slower than float32."""
    able = torch.cpu.get_capabilities()
    instructions = any(able.get(name, False) for name in ("avx512_bf16", "amx_bf16", "bf16"))
    return instructions and torch.backends.mkldnn.is_available()


def _convolution(channels_in: int, channels_out: int, size: int) -> nn.Conv2d:
    return skip_init(nn.Conv2d, channels_in, channels_out, size, padding=size // 2)


def _linear(features_in: int, features_out: int) -> nn.Linear:
    return skip_init(nn.Linear, features_in, features_out)


def _initialise(network: nn.Module, generator: torch.Generator | None) -> None:
    """He's initialisation for layers before a rectifier; outputs begin near zero."""
    for layer in network.modules():
        if isinstance(layer, nn.Conv2d | nn.Linear):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu", generator=generator)
            with torch.no_grad():
                if layer.bias is not None:
                    layer.bias.zero_()
                if isinstance(layer, nn.Linear) and layer.out_features <= 2:
                    layer.weight.mul_(0.1)
