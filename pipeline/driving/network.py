"""The network of the paper's primary (Appendix B): heads for affordances and actions, and its loss.

In the shapes, B is the number of images and c the channels of Conv1 to Conv4.
"""

import math
from dataclasses import dataclass, fields
from typing import Self

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from pipeline.driving.features import ACTIONS, AFFORDANCES, CAMERA, FEATURES, IMAGE_SHAPE
from pipeline.policies.loading import Config
from pipeline.policies.network import CHANNELS, ConvNetwork, initialise, linear

INDICATORS = AFFORDANCES[:5]
DISTANCES = AFFORDANCES[5:8]
POSITIONS = AFFORDANCES[8:]


class PrimaryNetwork(ConvNetwork):
    """Five convolutions, and one head for each of the ten affordances and two actions.

    Args:
        channels: c, the width of Conv1 to Conv4.
        brake_cut: [0, 1], it brakes where the brake's probability is above this.
        generator: draws the initial weights; PyTorch's global one where None.

    Raises:
        ValueError: `channels` is not positive.
    """

    camera = CAMERA
    measure = "steering-and-brake"

    def __init__(
        self,
        channels: int = CHANNELS,
        *,
        brake_cut: float = 0.5,
        generator: torch.Generator | None = None,
    ) -> None:
        super().__init__(IMAGE_SHAPE, channels)
        self.brake_cut = brake_cut
        self.seen, self.action = {CAMERA: FEATURES[CAMERA]}, FEATURES["action"]
        flat = self.feature_size
        self.outputs = nn.ModuleDict(
            {name: linear(flat, 2) for name in (*INDICATORS, "brake")}
            | {name: linear(flat, 1) for name in (*DISTANCES, *POSITIONS)}
            | {"steering": nn.Sequential(linear(flat, 64), nn.ReLU(), linear(64, 1))}
        )
        initialise(self, generator)

    @classmethod
    def of(cls, config: Config) -> Self:
        """As its configuration says; ValueError where that is not one."""
        return cls(config.number("channels"), brake_cut=float(config.number("brake_cut")))

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

    def act(self, looked: Tensor) -> Tensor:
        """Steering [-1, 1] and brake {0, 1}, [B, 2], from Conv5's activations."""
        return to_actions(*self.action_heads(looked), self.brake_cut)

    def _output(self, name: str, flat: Tensor) -> Tensor:
        output: Tensor = self.outputs[name](flat)
        return output.squeeze(1) if output.shape[1] == 1 else output


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


def to_actions(steering: Tensor, brake: Tensor, brake_cut: float) -> Tensor:
    """Actions float32 [B, 2] of `action_heads`: steering cut to [-1, 1], brake {0, 1}.

    The brake is on where its probability is above `brake_cut`.
    """
    on = brake.softmax(1)[:, 1] > brake_cut
    return torch.stack([steering.float().clamp(-1, 1), on.float()], 1)
