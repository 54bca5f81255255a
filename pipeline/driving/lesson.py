"""The paper's primary: it learns to steer and brake, and the affordances as further targets (Eq. 1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pipeline.data.schema import Feature
from pipeline.driving.features import CAMERA, IMITATED, SENSOR_RANGE
from pipeline.policies.lesson import Lesson
from pipeline.settings import Setting

if TYPE_CHECKING:
    import torch
    from lerobot.policies.pretrained import PreTrainedPolicy
    from numpy.typing import NDArray
    from torch import Tensor

    from pipeline.driving.network import LossWeights
    from pipeline.policies.network import ConvNetwork


@dataclass(frozen=True, kw_only=True)
class DrivingLesson(Lesson):
    """What the network is, and what each part of its loss counts for.

    Raises:
        ValueError: a number is out of its range.
    """

    name: ClassVar[str] = "driving"

    channels: Annotated[int, Setting("Of Conv1 to Conv4; 64 in the paper.", 1)] = 32
    jitter: Annotated[
        float, Setting("How far brightness, contrast and colours are moved, [0, 1).", 0, below=1)
    ] = 0.2
    mirror: Annotated[bool, Setting("Show half of the images as in a mirror, labels and all.")] = (
        True
    )
    steering_weight: Annotated[float, Setting("Weight of the steering in the loss.", 0)] = 40.0
    brake_weight: Annotated[float, Setting("Weight of the brake in the loss.", 0)] = 2.0
    brake_on: Annotated[
        float, Setting("Class weight of the brake being on, the rare label.", 0)
    ] = 3.0
    brake_cut: Annotated[
        float, Setting("Brake where its probability is above this.", 0, at_most=1)
    ] = 0.5

    def learned(self, features: Mapping[str, Feature]) -> Mapping[str, Feature]:
        """The front camera, the actions and the affordances."""
        return IMITATED

    def network(
        self,
        features: Mapping[str, Feature],
        columns: Mapping[str, NDArray],
        generator: torch.Generator,
    ) -> ConvNetwork:
        """The network of Appendix B."""
        from pipeline.driving.network import PrimaryNetwork

        return PrimaryNetwork(self.channels, brake_cut=self.brake_cut, generator=generator)

    def augment(self, batch: dict[str, Tensor], generator: torch.Generator) -> dict[str, Tensor]:
        """Half of the rows in the mirror, if so."""
        import torch

        from pipeline.driving.mirroring import mirror

        if not self.mirror:
            return batch
        chosen = torch.rand(len(batch["action"]), generator=generator) < 0.5
        names = (CAMERA, "action", "affordances")
        images, actions, affordances = (batch[name] for name in names)
        return dict(zip(names, mirror(images, actions, affordances, chosen), strict=True))

    def loss(
        self, network: ConvNetwork, looked: Tensor, batch: Mapping[str, Tensor]
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """The multi-task loss, and its parts."""
        from pipeline.driving.network import PrimaryNetwork, primary_loss

        assert isinstance(network, PrimaryNetwork)
        return primary_loss(
            network.heads(looked),
            batch["action"],
            batch["affordances"],
            sensor_range=SENSOR_RANGE,
            weights=self._weights(),
        )

    def policy(self, network: ConvNetwork) -> PreTrainedPolicy:
        """As LeRobot's type "safedagger_primary"."""
        from pipeline.driving.network import PrimaryNetwork
        from pipeline.driving.policy import PrimaryConfig, PrimaryPolicy

        assert isinstance(network, PrimaryNetwork)
        config = PrimaryConfig(
            channels=self.channels,
            sensor_range=SENSOR_RANGE,
            brake_cut=self.brake_cut,
            loss=self._weights(),
        )
        return PrimaryPolicy(config, network)

    def _weights(self) -> LossWeights:
        from pipeline.driving.network import LossWeights

        return LossWeights(
            steering=self.steering_weight, brake=self.brake_weight, brake_on=self.brake_on
        )
