"""A primary for any robot with a camera: it regresses the action on one image, and on the state if
there is one.

In the shapes, B is the batch, S the numbers of the state and A of the action.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from pipeline.data.schema import Feature, pictures
from pipeline.policies.lesson import Lesson
from pipeline.policies.loading import Config, feature
from pipeline.policies.network import ConvNetwork, initialise, linear
from pipeline.settings import Setting

if TYPE_CHECKING:
    from lerobot.policies.pretrained import PreTrainedPolicy
    from numpy.typing import NDArray

STATE = "observation.state"
SMALLEST = 1e-3  # of a standard deviation: what never moves is not made large


class ConvActor(ConvNetwork):
    """The paper's five convolutions, and two layers from there and the state to the action.

    `seen` are the column of one camera, and `STATE` if there is one; `action` is what it does.
    `channels`, c, is the width of Conv1 to Conv4, `hidden` that of the layer before the action;
    `generator` draws the initial weights, PyTorch's global one where None. ValueError where a width
    is not positive.
    """

    state_mean: Tensor
    state_std: Tensor
    action_mean: Tensor
    action_std: Tensor

    def __init__(
        self,
        seen: Mapping[str, Feature],
        action: Feature,
        *,
        channels: int,
        hidden: int,
        generator: torch.Generator | None = None,
    ) -> None:
        (camera,) = pictures(seen)
        height, width, colours = seen[camera]["shape"]
        super().__init__((height, width, colours), channels)
        self.camera, self.seen, self.action, self.hidden = camera, dict(seen), action, hidden
        self.numbers = seen[STATE]["shape"][0] if STATE in seen else 0
        self.feature_size += self.numbers
        self.layers = nn.Sequential(
            linear(self.feature_size, hidden), nn.ReLU(), linear(hidden, action["shape"][0])
        )
        initialise(self, generator)
        for name, size in (("state", self.numbers), ("action", action["shape"][0])):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_std", torch.ones(size))

    @classmethod
    def of(cls, config: Config) -> Self:
        """As its configuration says; ValueError where that is not one."""
        given = config.content
        try:
            seen = {
                n: feature(of["type"], of["shape"]) for n, of in given["input_features"].items()
            }
            action = feature("ACTION", given["output_features"]["action"]["shape"])
            channels, hidden = (int(config.number(name)) for name in ("channels", "hidden"))
            return cls(seen, action, channels=channels, hidden=hidden)
        except (KeyError, TypeError, AttributeError, IndexError) as error:
            raise ValueError(
                f"{config.path}: {error!r}, expected the features of a policy"
            ) from None

    def scale(self, columns: Mapping[str, NDArray]) -> None:
        """Bring state and action to mean 0 and standard deviation 1, as they are in `columns`."""
        for name, column in (("state", STATE), ("action", "action")):
            if column in self.seen or column == "action":
                values = torch.from_numpy(columns[column])
                getattr(self, f"{name}_mean").copy_(values.mean(0))
                getattr(self, f"{name}_std").copy_(values.std(0, correction=0).clamp(min=SMALLEST))

    def join(self, features: Tensor, seen: Mapping[str, Tensor]) -> Tensor:
        """[B, F]: the activations, and the state to their scale."""
        flat = features.flatten(1)
        if not self.numbers:
            return flat
        state = (seen[STATE].float() - self.state_mean) / self.state_std
        return torch.cat([flat, state], 1)

    def act(self, looked: Tensor) -> Tensor:
        """[B, A], within no limits but what it learned."""
        return self.layers(looked) * self.action_std + self.action_mean

    def error(self, looked: Tensor, action: Tensor) -> Tensor:
        """The mean squared error of what it does, on the scale of the actions."""
        apart = (self.act(looked) - action) / self.action_std
        return F.mse_loss(apart, torch.zeros_like(apart))


@dataclass(frozen=True, kw_only=True)
class ConvLesson(Lesson):
    """What the network is; ValueError where a number is out of its range."""

    name: ClassVar[str] = "conv"

    channels: Annotated[int, Setting("Of Conv1 to Conv4; Conv5 has twice as many.", 1)] = 16
    hidden: Annotated[int, Setting("Width of the layer before the action.", 1)] = 128
    jitter: Annotated[
        float, Setting("How far brightness, contrast and colours are moved, [0, 1).", 0, below=1)
    ] = 0.0

    def learned(self, features: Mapping[str, Feature]) -> Mapping[str, Feature]:
        """The one camera, the state if there is one, and the action."""
        cameras = pictures(features)
        if len(cameras) != 1:
            raise ValueError(f"cameras are {', '.join(cameras) or 'none'}, expected a single one")
        return {name: features[name] for name in (cameras[0], STATE, "action") if name in features}

    def network(
        self,
        features: Mapping[str, Feature],
        columns: Mapping[str, NDArray],
        generator: torch.Generator,
    ) -> ConvNetwork:
        """Of the sizes and the scales of the columns."""
        seen = {name: of for name, of in features.items() if name != "action"}
        network = ConvActor(
            seen,
            features["action"],
            channels=self.channels,
            hidden=self.hidden,
            generator=generator,
        )
        network.scale(columns)
        return network

    def loss(
        self, network: ConvNetwork, looked: Tensor, batch: Mapping[str, Tensor]
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """The squared error of the action, on its scale."""
        assert isinstance(network, ConvActor)
        loss = network.error(looked, batch["action"])
        return loss, {"action": loss}

    def policy(self, network: ConvNetwork) -> PreTrainedPolicy:
        """As LeRobot's type "safedagger_conv"."""
        from pipeline.policies.conv_policy import ConvPolicy

        assert isinstance(network, ConvActor)
        return ConvPolicy.of(network)
