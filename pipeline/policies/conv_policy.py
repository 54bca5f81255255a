"""The primary for any robot as LeRobot knows policies. In the shapes, B is the batch."""

from dataclasses import dataclass, field
from typing import Any, Self

import torch
from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import FeatureType, NormalizationMode, PolicyFeature
from lerobot.processor.factory import make_default_pre_post_processors
from lerobot.utils.constants import ACTION
from torch import Tensor

from pipeline.policies.conv import ConvActor
from pipeline.policies.loading import CONV_TYPE, feature
from pipeline.policies.offline import OfflineConfig, OfflinePolicy


@PreTrainedConfig.register_subclass(CONV_TYPE)
@dataclass
class ConvConfig(OfflineConfig):
    """A convolutional primary; what it sees and does are LeRobot's features."""

    channels: int = 16
    """>= 1, of Conv1 to Conv4."""
    hidden: int = 128
    """>= 1, width of the layer before the action."""

    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: dict.fromkeys(
            ("VISUAL", "STATE", "ACTION"), NormalizationMode.IDENTITY
        )
    )

    def validate_features(self) -> None:
        """Raise a ValueError unless there are one camera and an action."""
        kinds = [feature.type for feature in (self.input_features or {}).values()]
        if kinds.count(FeatureType.VISUAL) != 1 or ACTION not in (self.output_features or {}):
            raise ValueError(f"input_features are {kinds}, expected one camera, and an action")


class ConvPolicy(OfflinePolicy):
    """A convolutional primary: its network, its loss, and the actions it drives with. `network` is of
    the features and widths of `config`; None draws one from PyTorch's global generator. ValueError for
    features that it cannot have.
    """

    config_class = ConvConfig
    name = CONV_TYPE
    network: ConvActor

    def __init__(self, config: ConvConfig, network: ConvActor | None = None, **_: Any) -> None:
        super().__init__(config)
        config.validate_features()
        self.network = network if network is not None else _new(config)

    @classmethod
    def of(cls, network: ConvActor) -> Self:
        """The policy of a trained network."""
        seen = {}
        for name, column in network.seen.items():
            shape = tuple(column["shape"])
            visual = name == network.camera
            shape = (shape[2], *shape[:2]) if visual else shape
            seen[name] = PolicyFeature(FeatureType.VISUAL if visual else FeatureType.STATE, shape)
        done = {ACTION: PolicyFeature(FeatureType.ACTION, tuple(network.action["shape"]))}
        config = ConvConfig(
            channels=network.channels,
            hidden=network.hidden,
            input_features=seen,
            output_features=done,
        )
        return cls(config, network)

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict[str, float]]:
        """The squared error of the action on its scale, for images float [B, 3, H, W] in [0, 1]."""
        loss = self.network.error(self._look(batch), batch[ACTION])
        return loss, {"action": loss.item()}

    @torch.no_grad()
    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """Actions float32 [B, A]."""
        return self.network.act(self._look(batch))

    def _look(self, batch: dict[str, Tensor]) -> Tensor:
        return self.network.join(self.network.features(batch[self.network.camera]), batch)


def _new(config: ConvConfig) -> ConvActor:
    seen, done = config.input_features or {}, (config.output_features or {})[ACTION]
    return ConvActor(
        {name: feature(of.type.name, of.shape) for name, of in seen.items()},
        feature("ACTION", done.shape),
        channels=config.channels,
        hidden=config.hidden,
    )


make_safedagger_conv_pre_post_processors = make_default_pre_post_processors
"""By whose name LeRobot finds it; with identity normalisation the statistics do not matter."""
