"""Driving with trained networks, and reading them from disk, without LeRobot.

Plain PyTorch: quick to import in the processes that drive. In the shapes, N is the number of images
and F the numbers in Conv5's activations of one.
"""

import copy
import json
from pathlib import Path
from types import UnionType
from typing import Any, Self

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from pipeline.data.schema import IMAGE_SHAPE
from pipeline.policies.computing import computing
from pipeline.policies.network import (
    PrimaryNetwork,
    SafetyNetwork,
    feature_size,
    has_bfloat16,
    to_actions,
    to_float,
)
from pipeline.policies.strategies import Rule, Strategy

CONFIG_FILE = "config.json"
WEIGHTS_FILE = "model.safetensors"
"""What a directory models/<policy>_<iteration> holds, with LeRobot's processors beside them."""

PRIMARY_TYPE = "safedagger_primary"
SAFETY_TYPE = "safedagger_safety"
"""LeRobot's names for the two kinds of policies."""

_PROPOSED = 32
"""Images at a time: more do not fit into a processor's cache."""


class Driver:
    """A primary policy and, where there is one, its safety policy, ready to drive.

    It can be pickled. The networks are copies: training the originals further changes nothing here.

    Args:
        primary: a trained primary network.
        safety: the safety network that was trained on this primary's Conv5.
        brake_cut: [0, 1], the brake is on where its probability is above this.
        bfloat16: whether the convolutions may compute in bfloat16, on processors that can.

    Raises:
        ValueError: `safety` does not fit the primary's Conv5.
    """

    def __init__(
        self,
        primary: PrimaryNetwork,
        safety: SafetyNetwork | None = None,
        *,
        brake_cut: float,
        bfloat16: bool = True,
    ) -> None:
        size = feature_size(primary.channels)
        if safety is not None and safety.in_features != size:
            raise ValueError(
                f"safety takes {safety.in_features} numbers, expected the {size} of this "
                "primary's Conv5"
            )
        self.primary = _ready(primary, bfloat16)
        self.safety = copy.deepcopy(safety).eval() if safety is not None else None
        self.brake_cut = brake_cut

    @classmethod
    def load(cls, primary: Path, safety: Path | None = None, *, bfloat16: bool = True) -> Self:
        """The policies saved in two directories, such as models/primary_0 and models/safety_0.

        Raises:
            ValueError: files are missing, of another kind of policy, or do not fit.
        """
        config = read_config(primary, PRIMARY_TYPE)
        return cls(
            load_primary(primary),
            load_safety(safety) if safety is not None else None,
            brake_cut=float(_field(primary, config, "brake_cut", int | float)),
            bfloat16=bfloat16,
        )

    def act(self, image: np.ndarray) -> tuple[np.ndarray, Tensor]:
        """The primary's action for one camera image, and the Conv5 activations behind it.

        Args:
            image: uint8 [72, 160, 3].

        Returns:
            float32 [2], steering [-1, 1] and brake {0, 1}; and a tensor for `safe_probability`.

        Raises:
            ValueError: another shape or type of image.
        """
        if image.shape != IMAGE_SHAPE or image.dtype != np.uint8:
            raise ValueError(f"image is {image.dtype} {image.shape}, expected uint8 {IMAGE_SHAPE}")
        with torch.inference_mode():
            actions, conv5 = _propose(self.primary, torch.tensor(image)[None], self.brake_cut)
        return actions[0].numpy(), conv5

    def safe_probability(self, conv5: Tensor) -> float:
        """The probability [0, 1] that the primary is safe (Eq. 2), from `act`'s second result.

        Raises:
            ValueError: there is no safety policy.
        """
        if self.safety is None:
            raise ValueError("this driver has no safety policy, expected one")
        with torch.inference_mode():
            return float(self.safety(conv5).softmax(1)[0, 1])


def propose(
    network: PrimaryNetwork, images: np.ndarray, *, brake_cut: float, bfloat16: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """What a primary proposes for many images, and Conv5's activations, in one pass.

    Args:
        network: a trained primary network.
        images: uint8 [N, 72, 160, 3].
        brake_cut: [0, 1], the brake is on where its probability is above this.
        bfloat16: as for `Driver`.

    Returns:
        float32 [N, 2], steering [-1, 1] and brake {0, 1}; and float16 [N, F].
    """
    ready = _ready(network, bfloat16)
    actions = np.empty((len(images), 2), np.float32)
    conv5 = np.empty((len(images), feature_size(network.channels)), np.float16)
    with torch.inference_mode(), computing():
        for start in range(0, len(images), _PROPOSED):
            rows = slice(start, start + _PROPOSED)
            proposed, features = _propose(ready, torch.tensor(images[rows]), brake_cut)
            actions[rows] = proposed.numpy()
            conv5[rows] = features.flatten(1).half().numpy()
    return actions, conv5


def load_primary(directory: Path) -> PrimaryNetwork:
    """The primary network in a policy's directory; ValueError where it is missing or misfits."""
    config = read_config(directory, PRIMARY_TYPE)
    network = PrimaryNetwork(_field(directory, config, "channels", int))
    load_weights(network, directory)
    return network


def load_safety(directory: Path) -> SafetyNetwork:
    """The safety network in a policy's directory; ValueError where it is missing or misfits."""
    config = read_config(directory, SAFETY_TYPE)
    channels, hidden = (_field(directory, config, name, int) for name in ("channels", "hidden"))
    network = SafetyNetwork(feature_size(channels), hidden)
    load_weights(network, directory)
    return network


def read_config(directory: Path, kind: str) -> dict[str, Any]:
    """The configuration of the policy in `directory`.

    Raises:
        ValueError: there is none, it is not JSON, or not of this kind of policy.
    """
    path = Path(directory) / CONFIG_FILE
    try:
        config = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}, expected a saved {kind} policy") from None
    except ValueError as error:
        raise ValueError(f"{path}: not JSON ({error}), expected a saved {kind} policy") from None
    found = config.get("type") if isinstance(config, dict) else None
    if found != kind:
        raise ValueError(f"{path}: the policy's type is {found!r}, expected {kind!r}")
    return config


def driving_rule(safety: Path, strategy: Strategy, cut: float) -> Rule:
    """The rule of a driving strategy for a primary that the policy in `safety` watches.

    What deviates, for OPTIMAL, is what the policy's labels were made by.

    Raises:
        ValueError: as `read_config`; `cut` is out of its range.
    """
    labels = read_config(safety, SAFETY_TYPE)
    return Rule(strategy, cut=cut, tau=labels["tau"], include_brake=labels["include_brake"])


def load_weights(network: nn.Module, directory: Path) -> None:
    """Fill `network` with the weights saved in `directory`: all of them, and no others.

    Raises:
        ValueError: the file is missing or damaged, or a name, shape or type does not fit.
    """
    path = Path(directory) / WEIGHTS_FILE
    if not path.is_file():
        raise ValueError(f"{path} is missing, expected the weights of a policy")
    try:
        saved = load_file(path)
    except SafetensorError as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"{path}: {reason}, expected the weights of a policy") from None
    wanted = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    for name in sorted(wanted.keys() | saved.keys()):
        found, expected = (_describe(weights.get(name)) for weights in (saved, wanted))
        if found != expected:
            raise ValueError(f"{path}: {name} is {found}, expected {expected}")
    network.load_state_dict({name.removeprefix("network."): saved[name] for name in saved})


def _propose(ready: PrimaryNetwork, images: Tensor, brake_cut: float) -> tuple[Tensor, Tensor]:
    conv5 = ready.features(to_float(images)).float()
    return to_actions(*ready.action_heads(conv5), brake_cut), conv5


def _ready(network: PrimaryNetwork, bfloat16: bool) -> PrimaryNetwork:
    """A copy to infer with; converted once here, not at each image as autocast would."""
    ready = copy.deepcopy(network).eval().requires_grad_(False)
    if bfloat16 and has_bfloat16():
        for convolution in ready.convolutions():
            convolution.to(torch.bfloat16)
    return ready


def _describe(weights: Tensor | None) -> str:
    return "none" if weights is None else f"{weights.dtype} {list(weights.shape)}"


def _field(directory: Path, config: dict[str, Any], name: str, kind: type | UnionType) -> Any:
    if not isinstance(config.get(name), kind):
        path = Path(directory) / CONFIG_FILE
        raise ValueError(f"{path}: {name} is {config.get(name)!r}, expected a number")
    return config[name]
