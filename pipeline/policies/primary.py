"""The primary policy as LeRobot knows policies: saved, loaded and run by its tools.

LeRobot finds `PrimaryPolicy` and its processors from `PrimaryConfig` by their names.
In the shapes, B is the batch.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import draccus
import torch
from draccus.utils import DraccusException
from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import FeatureType, NormalizationMode, PolicyFeature
from lerobot.optim import AdamWConfig
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.processor import PolicyProcessorPipeline
from lerobot.processor.factory import make_default_pre_post_processors
from lerobot.utils.constants import ACTION
from torch import Tensor, nn

from pipeline.driving.features import ACTIONS, CAMERA, IMAGE_SHAPE
from pipeline.policies.loading import CONFIG_FILE, PRIMARY_TYPE, load_weights, read_config
from pipeline.policies.network import (
    CHANNELS,
    LossWeights,
    PrimaryNetwork,
    primary_loss,
    to_actions,
)

_CHANNELS_FIRST = (IMAGE_SHAPE[2], *IMAGE_SHAPE[:2])

Processors = tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]],
    PolicyProcessorPipeline[Tensor, Tensor],
]


class OfflineConfig(PreTrainedConfig):
    """What the two configurations of this project share: no Hub, no history, no normalisation."""

    @property
    def observation_delta_indices(self) -> None:
        """One observation, the present one."""
        return None

    @property
    def action_delta_indices(self) -> None:
        """One action, for the present."""
        return None

    @property
    def reward_delta_indices(self) -> None:
        """No rewards."""
        return None

    def get_optimizer_preset(self) -> AdamWConfig:
        """For LeRobot's own training only; ours is in `pipeline.learning`."""
        return AdamWConfig()

    def get_scheduler_preset(self) -> None:
        """For LeRobot's own training only; ours is in `pipeline.learning`."""
        return None


class OfflinePolicy(PreTrainedPolicy):
    """What the two policies share: saved with their processors, loaded strictly, no memory.

    A subclass keeps its weights in `network`. The same policy is saved as the same bytes.
    """

    config_class: type[PreTrainedConfig] = OfflineConfig
    name: str = "safedagger"
    network: nn.Module

    def _save_pretrained(
        self, save_directory: Path, state_dict: dict[str, Tensor] | None = None
    ) -> None:
        super()._save_pretrained(save_directory, state_dict)
        for processor in make_default_pre_post_processors(self.config):
            processor.save_pretrained(save_directory)

    @classmethod
    def from_pretrained(
        cls,
        pretrained_name_or_path: str | Path,
        *,
        config: PreTrainedConfig | None = None,
        **_: Any,
    ) -> Self:
        """The policy saved in a directory, in evaluation mode.

        Args:
            pretrained_name_or_path: the directory.
            config: used instead of the saved one.

        Raises:
            ValueError: files are missing, of another kind of policy, or do not fit.
        """
        directory = Path(pretrained_name_or_path)
        saved = read_config(directory, cls.name)
        del saved["type"]
        try:
            policy = cls(config or draccus.decode(cls.config_class, saved))
        except (DraccusException, ValueError, TypeError) as error:
            reason = " ".join(f"{error} {error.__cause__ or ''}".split())
            raise ValueError(f"{directory / CONFIG_FILE}: {reason}") from None
        load_weights(policy.network, directory)
        return policy.to(policy.config.device).eval()

    def predict_action_chunk(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """`select_action` as a chunk of one action, [B, 1, number of actions]."""
        return self.select_action(batch)[:, None]

    def reset(self) -> None:
        """Nothing: the policy has no memory."""

    def get_optim_params(self) -> Any:
        """All parameters."""
        return self.parameters()


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

    device: str | None = "cpu"
    push_to_hub: bool = False
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
        self.network = network if network is not None else PrimaryNetwork(config.channels)
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
        heads = self.network.action_heads(self.network.features(batch[CAMERA]))
        return to_actions(*heads, self.config.brake_cut)


def make_safedagger_primary_pre_post_processors(
    config: PrimaryConfig, dataset_stats: dict[str, dict[str, Tensor]] | None = None
) -> Processors:
    """LeRobot's default processors; with identity normalisation the statistics do not matter."""
    return make_default_pre_post_processors(config, dataset_stats)


def check_feature(
    side: str, features: dict[str, PolicyFeature] | None, name: str, shape: tuple[int, ...]
) -> None:
    """Raise a ValueError unless `features` is `name` of `shape` alone."""
    found = {key: tuple(feature.shape) for key, feature in (features or {}).items()}
    expected = {name: shape}
    if found != expected:
        raise ValueError(f"{side}_features is {found}, expected {expected}")
