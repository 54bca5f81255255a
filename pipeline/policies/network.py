"""The convolutions of Appendix B, which primaries are built on, and the safety policy's network.

Plain PyTorch. In the shapes, B is the number of images and c the channels of Conv1 to Conv4.
"""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from pipeline.data.schema import Feature

CHANNELS = 64
"""Channels of Conv1 to Conv4 in the paper; Conv5 has twice as many."""


class Actor(nn.Module):
    """What a primary is to all that drives it and watches over it, whoever trained it."""

    seen: Mapping[str, Feature]
    """all columns that it drives by, as LeRobot describes them"""
    action: Feature
    """what it does"""
    feature_size: int
    """numbers that a safety policy reads of one frame"""
    chunk: int = 1
    """actions that it plans at a time, to be done one after the other, a frame each"""
    measure: ClassVar[str] = "mean-square"
    """how far its actions are from the reference's, unless its safety policy is told otherwise: a
    name of `registry.MEASURES`"""

    @property
    def device(self) -> torch.device:
        """Where its weights are, and all that it takes and gives."""
        return next(self.parameters()).device

    def look(self, seen: Mapping[str, Tensor]) -> Tensor:
        """What a safety policy reads, float [B, ...], of columns [B, ...]; images are uint8."""
        raise NotImplementedError

    def act(self, looked: Tensor) -> Tensor:
        """Actions float32 [B, A], from the result of `look`."""
        raise NotImplementedError

    def plan(self, seen: Mapping[str, Tensor], length: int) -> tuple[Tensor, Tensor]:
        """The result of `look`, and the next `length` actions, at most `chunk`: [B, length, A]."""
        looked = self.look(seen)
        return looked, self.act(looked)[:, None]

    def doing(self, looked: Tensor, action: Tensor) -> Tensor:
        """What a safety policy reads where `action` [B, A] is done, which was planned earlier; here
        what was `looked` at, since no action is in it.
        """
        return looked

    def convolutions(self) -> tuple[nn.Conv2d, ...]:
        """What may be computed in bfloat16, on processors that can."""
        return ()


class ConvNetwork(Actor):
    """Five convolutions on the image of one camera, of `image_shape` [H, W, colours]; a subclass adds
    what turns them into actions. `channels`, c, is the width of Conv1 to Conv4; ValueError unless it
    is positive.
    """

    camera: str
    """the column that it looks at"""

    def __init__(self, image_shape: tuple[int, int, int], channels: int) -> None:
        super().__init__()
        if channels < 1:
            raise ValueError(f"channels is {channels}, expected at least 1")
        self.image_shape, self.channels = image_shape, channels
        self.conv1 = convolution(image_shape[2], channels, 3)
        self.conv2 = convolution(channels, channels, 3)
        self.conv3 = convolution(channels, channels, 3)
        self.conv4 = convolution(channels, channels, 3)
        self.conv5 = convolution(channels, 2 * channels, 5)
        height, width, _ = image_shape  # after four poolings by 2
        self.feature_size = 2 * channels * (height // 16) * (width // 16)

    def convolutions(self) -> tuple[nn.Conv2d, ...]:
        """Conv1 to Conv5."""
        return self.conv1, self.conv2, self.conv3, self.conv4, self.conv5

    def features(self, images: Tensor, kind: torch.dtype | None = None) -> Tensor:
        """Conv5's activations [B, 2c, H // 16, W // 16] of `images` float [B, 3, H, W] in [0, 1].

        They are computed in `kind`, by default that of the weights.
        """
        # Centred on mid-grey, it learns faster than from positive numbers alone.
        x = images.mul(2).sub_(1).to(kind or self.conv1.weight.dtype)
        if x.device.type == "cpu" and torch.backends.mkldnn.is_available():
            x = x.to_mkldnn()  # so oneDNN pools, too: in much less time than PyTorch
        else:
            x = x.contiguous(memory_format=torch.channels_last)
        for convolution in self.convolutions()[:4]:
            # The rectifier and the maximum commute: after the pooling it has a quarter to do.
            x = F.relu(F.max_pool2d(convolution(x), 2, 2))
        x = F.relu(self.conv5(x))
        return x.to_dense() if x.is_mkldnn else x

    def look(self, seen: Mapping[str, Tensor]) -> Tensor:
        """Conv5's activations with what else is `seen`, see `join`."""
        return self.join(self.features(to_float(seen[self.camera])).float(), seen)

    def join(self, features: Tensor, seen: Mapping[str, Tensor]) -> Tensor:
        """Conv5's activations with what else is `seen`; here nothing."""
        return features


class Convolution(nn.Conv2d):
    """One with as large an output as its input, that computes in the type and layout of the latter."""

    def forward(self, x: Tensor) -> Tensor:
        """[B, C', H, W] of `x` [B, C, H, W]."""
        assert self.bias is not None
        weight, bias = self.weight.to(x.dtype), self.bias.to(x.dtype)
        padding = weight.shape[-1] // 2
        if not x.is_mkldnn:
            return F.conv2d(x, weight, bias, padding=padding)
        # What F.conv2d would call, but it refuses bfloat16 in this layout.
        return torch.mkldnn_convolution(x, weight, bias, (padding, padding), (1, 1), (1, 1), 1)


class SafetyNetwork(nn.Module):
    """Two hidden layers, `hidden` wide, on the `in_features` numbers of what a primary looked at in a
    frame; two logits, index 1 being safe (Eq. 2). `generator` draws the initial weights, PyTorch's
    global one where None. ValueError where a width is not positive.
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
            linear(in_features, hidden),
            nn.ReLU(),
            linear(hidden, hidden),
            nn.ReLU(),
            linear(hidden, 2),
        )
        initialise(self, generator)

    def forward(self, features: Tensor) -> Tensor:
        """Logits [B, 2] of `features` [B, ...], in_features numbers each, of any float type."""
        # Detached: what the safety policy learns must never change the primary.
        logits: Tensor = self.layers(features.detach().flatten(1).float())
        return logits


def to_float(images: Tensor) -> Tensor:
    """`images` uint8 [B, H, W, 3] as the network takes them: float [B, 3, H, W] in [0, 1]."""
    # A colour's numbers side by side: jitter and oneDNN take half the time.
    planes = torch.contiguous_format
    return images.permute(0, 3, 1, 2).to(torch.float32, memory_format=planes).div_(255)


def has_bfloat16(device: torch.device) -> bool:
    """Whether it is a processor that computes in bfloat16 itself; emulated, it is slower than float32.

    A GPU is quick enough in float32.
    """
    able = torch.cpu.get_capabilities()
    instructions = any(able.get(name, False) for name in ("avx512_bf16", "amx_bf16", "bf16"))
    return device.type == "cpu" and instructions and torch.backends.mkldnn.is_available()


def convolution(channels_in: int, channels_out: int, size: int) -> Convolution:
    """Its weights are yet to be drawn."""
    return _undrawn(Convolution, channels_in, channels_out, size, padding=size // 2)


def linear(features_in: int, features_out: int) -> nn.Linear:
    """Its weights are yet to be drawn."""
    return _undrawn(nn.Linear, features_in, features_out)


def _undrawn[Layer: nn.Module](kind: Callable[..., Layer], *sizes: int, **named: Any) -> Layer:
    """A layer that took nothing from PyTorch's global generator, though each draws when it is made.

    PyTorch's own `skip_init` imports a computer algebra for that, which takes a second.
    """
    with torch.random.fork_rng(devices=[]):
        return kind(*sizes, **named)


def initialise(network: nn.Module, generator: torch.Generator | None) -> None:
    """He's initialisation for layers before a rectifier; outputs begin near zero."""
    for layer in network.modules():
        if isinstance(layer, nn.Conv2d | nn.Linear):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu", generator=generator)
            with torch.no_grad():
                if layer.bias is not None:
                    layer.bias.zero_()
                if isinstance(layer, nn.Linear) and layer.out_features <= 2:
                    layer.weight.mul_(0.1)
