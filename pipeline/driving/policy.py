"""The primary policy as LeRobot knows policies: saved, loaded and run by its tools.

LeRobot finds `PrimaryPolicy` and its processors from `PrimaryConfig` by their names.
In the shapes, B is the batch.
"""

from dataclasses import dataclass, field
from typing import Any

import torch
from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import FeatureType, NormalizationMode, PolicyFeature
from lerobot.processor.factory import make_default_pre_post_processors
from lerobot.utils.constants import ACTION
from torch import Tensor

from pipeline.driving.features import ACTIONS, CAMERA, IMAGE_SHAPE
from pipeline.driving.network import LossWeights, PrimaryNetwork, primary_loss
from pipeline.policies.loading import PRIMARY_TYPE
from pipeline.policies.network import CHANNELS
from pipeline.policies.offline import OfflineConfig, OfflinePolicy, check_feature

_CHANNELS_FIRST = (IMAGE_SHAPE[2], *IMAGE_SHAPE[:2])


@PreTrainedConfig.register_subclass(PRIMARY_TYPE)
@dataclass
class PrimaryConfig(OfflineConfig):
    """A primary policy.

    Raises:
        ValueError: a field is out of its range.
    """

    channels: int = CHANNELS
    """>= 1, of Conv1 to Conv4."""
    sensor_range: float = 60.0
    """> 0 [m], the distance that is predicted as 1."""
    brake_cut: float = 0.85
    """[0, 1]: it brakes where the brake's probability is above this. Above 0.5, since the class
    weight of the brake raises its probability."""
    loss: LossWeights = field(default_factory=LossWeights)

    input_features: dict[str, PolicyFeature] | None = field(
        default_factory=lambda: {CAMERA: PolicyFeature(FeatureType.VISUAL, _CHANNELS_FIRST)}
    )
    output_features: dict[str, PolicyFeature] | None = field(
        default_factory=lambda: {ACTION: PolicyFeature(FeatureType.ACTION, (len(ACTIONS),))}
    )
    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: dict.fromkeys(("VISUAL", "ACTION"), NormalizationMode.IDENTITY)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 <= self.brake_cut <= 1:
            raise ValueError(f"brake_cut is {self.brake_cut}, expected a number from 0 to 1")
        if not self.sensor_range > 0:
            raise ValueError(f"sensor_range is {self.sensor_range}, expected a number above 0")

    def validate_features(self) -> None:
        """Raise a ValueError unless it is from the front camera to steering and brake."""
        check_feature("input", self.input_features, CAMERA, _CHANNELS_FIRST)
        check_feature("output", self.output_features, ACTION, (len(ACTIONS),))


class PrimaryPolicy(OfflinePolicy):
    """A primary policy: the network of Appendix B, its loss, and the actions it drives with.

    Args:
        config: see `PrimaryConfig`.
        network: trained with `config.channels`; None draws one from PyTorch's global generator.

    Raises:
        ValueError: a network of other channels, or other features than camera and actions.
    """

    config_class = PrimaryConfig
    name = PRIMARY_TYPE
    network: PrimaryNetwork

    def __init__(
        self, config: PrimaryConfig, network: PrimaryNetwork | None = None, **_: Any
    ) -> None:
        super().__init__(config)
        config.validate_features()
        self.network = (
            network
            if network is not None
            else PrimaryNetwork(config.channels, brake_cut=config.brake_cut)
        )
        if self.network.channels != config.channels:
            raise ValueError(
                f"network has {self.network.channels} channels, expected {config.channels}"
            )

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict[str, float]]:
        """The multi-task loss of a batch, and its parts.

        Args:
            batch: the camera float [B, 3, 72, 160] in [0, 1], "action" [B, 2], and "affordances"
                [B, 10], which LeRobot's own training leaves out: then the actions alone count.
        """
        loss, parts = primary_loss(
            self.network(batch[CAMERA]),
            batch[ACTION],
            batch.get("affordances"),
            sensor_range=self.config.sensor_range,
            weights=self.config.loss,
        )
        return loss, {name: part.item() for name, part in parts.items()}

    @torch.no_grad()
    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """Actions float32 [B, 2] for the camera [B, 3, 72, 160]: steering [-1, 1], brake {0, 1}."""
        return self.network.act(self.network.features(batch[CAMERA]))


make_safedagger_primary_pre_post_processors = make_default_pre_post_processors
"""By whose name LeRobot finds it; with identity normalisation the statistics do not matter."""
