"""What our policies share where LeRobot knows them: saved with their processors, loaded strictly,
without the Hub. In the shapes, B is the batch.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import draccus
from draccus.utils import DraccusException
from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import PolicyFeature
from lerobot.optim import AdamWConfig
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.processor.factory import make_default_pre_post_processors
from torch import Tensor, nn

from pipeline.policies.loading import CONFIG_FILE, load_weights, read_config


@dataclass
class OfflineConfig(PreTrainedConfig):
    """What the configurations of this project share: no Hub, no history, no normalisation."""

    device: str | None = "cpu"
    push_to_hub: bool = False

    # one observation and one action, of the present, and no rewards
    observation_delta_indices = action_delta_indices = reward_delta_indices = None

    def get_optimizer_preset(self) -> AdamWConfig:
        """For LeRobot's own training only; ours is in `pipeline.learning`."""
        return AdamWConfig()

    def get_scheduler_preset(self) -> None:
        """For LeRobot's own training only; ours is in `pipeline.learning`."""
        return None


class OfflinePolicy(PreTrainedPolicy):
    """What the policies share: saved with their processors, loaded strictly, no memory.

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
        """The policy saved in a directory, in evaluation mode; with `config` in the place of its own.
        ValueError where files are missing, of another kind of policy, or do not fit.
        """
        directory = Path(pretrained_name_or_path)
        saved = {**read_config(directory, cls.name).content}
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


def check_feature(
    side: str, features: dict[str, PolicyFeature] | None, name: str, shape: tuple[int, ...]
) -> None:
    """Raise a ValueError unless `features` is `name` of `shape` alone."""
    found = {key: tuple(feature.shape) for key, feature in (features or {}).items()}
    expected = {name: shape}
    if found != expected:
        raise ValueError(f"{side}_features is {found}, expected {expected}")
