"""The safety policy as LeRobot knows policies. In the shapes, B is the batch.

Its observation is what a primary looked at, of ours its Conv5; its action is 1, safe, or 0 (Eq. 2).
"""

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import torch
import torch.nn.functional as F
from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import FeatureType, NormalizationMode, PolicyFeature
from lerobot.processor.factory import make_default_pre_post_processors
from lerobot.utils.constants import ACTION
from torch import Tensor

from pipeline.policies.loading import SAFETY_TYPE
from pipeline.policies.network import SafetyNetwork
from pipeline.policies.offline import OfflineConfig, OfflinePolicy, check_feature
from pipeline.settings import Setting

FEATURES = "observation.features"


@PreTrainedConfig.register_subclass(SAFETY_TYPE)
@dataclass
class SafetyConfig(OfflineConfig):
    """A safety policy: what it is, and by what rule its labels were made; ValueError where a field is out
    of its range.
    """

    primary_sha256: str = ""
    """Of the weights file of the primary that it watches: it fits no other."""
    features_of: str = ""
    """Of a primary of LeRobot's: the module whose input it reads; see `lerobot.LeRobotActor`."""
    features: int = 1
    """>= 1, numbers that it reads of what its primary looked at."""
    hidden: int = 64
    """>= 1, width of each of the two hidden layers."""
    tau: float = 0.0025
    """>= 0, the threshold: a frame is safe where the deviation is at most this."""
    cut: float = 0.5
    """[0, 1]: unsafe is what has a `safe_probability` below this."""
    horizon: float = 0.0
    """>= 0 [s], how far ahead the labels look."""
    horizon_mode: Literal["last", "max"] = "last"
    """Whether they take the deviation at the end of the horizon, or the largest within."""
    measure: str = "mean-square"
    """What deviates: a name of `registry.MEASURES`."""
    half_range: list[float] = field(default_factory=list)
    """Of each number of an action, by which that measures."""
    balance: float = 0.0
    """[0, 1], class weights in its training: 0 none, 1 balanced."""

    input_features: dict[str, PolicyFeature] | None = None
    output_features: dict[str, PolicyFeature] | None = field(
        default_factory=lambda: {ACTION: PolicyFeature(FeatureType.ACTION, (1,))}
    )
    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: dict.fromkeys(("STATE", "ACTION"), NormalizationMode.IDENTITY)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, highest in (("tau", math.inf), ("cut", 1), ("horizon", math.inf), ("balance", 1)):
            Setting(name, 0, at_most=highest).check(name, getattr(self, name))
        if self.input_features is None:
            self.input_features = {FEATURES: PolicyFeature(FeatureType.STATE, (self.features,))}

    def validate_features(self) -> None:
        """Raise a ValueError unless it is from what its primary looked at to one number."""
        check_feature("input", self.input_features, FEATURES, (self.features,))
        check_feature("output", self.output_features, ACTION, (1,))


class SafetyPolicy(OfflinePolicy):
    """A safety policy: two hidden layers on what its primary looked at, and Eq. 4's loss. `network` has
    the sizes in `config`; None draws one from PyTorch's global generator. ValueError for a network of
    another size, or other features than these and one action.
    """

    config_class = SafetyConfig
    name = SAFETY_TYPE
    network: SafetyNetwork

    def __init__(
        self, config: SafetyConfig, network: SafetyNetwork | None = None, **_: Any
    ) -> None:
        super().__init__(config)
        config.validate_features()
        size = config.features
        self.network = network if network is not None else SafetyNetwork(size, config.hidden)
        found = self.network.in_features, self.network.hidden
        if found != (size, config.hidden):
            raise ValueError(
                f"network has {found} inputs and hidden units, expected {(size, config.hidden)}"
            )

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, None]:
        """Eq. 4 for a batch: `FEATURES` [B, F], and "action" [B, 1], 1 where safe and 0 where not."""
        labels = batch[ACTION].flatten().long()
        return F.cross_entropy(self.network(batch[FEATURES]), labels), None

    @torch.no_grad()
    def safe_probability(self, features: Tensor) -> Tensor:
        """The probability [B] that the primary is safe, from what it looked at [B, F]."""
        return self.network(features).softmax(1)[:, 1]

    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """float32 [B, 1]: 0 where `FEATURES` [B, F] looks unsafe, else 1."""
        return (self.safe_probability(batch[FEATURES]) >= self.config.cut).float()[:, None]


make_safedagger_safety_pre_post_processors = make_default_pre_post_processors
"""By whose name LeRobot finds it; with identity normalisation the statistics do not matter."""
