"""Driving with trained networks, without LeRobot.

Plain PyTorch: quick to import in the processes that drive. In the shapes, N is the number of images
and F the numbers in Conv5's activations of one.
"""

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Self

import numpy as np
import torch
from torch import Tensor

from pipeline.driving.features import CAMERA, IMAGE_SHAPE
from pipeline.policies.computing import computing
from pipeline.policies.loading import check_pair, load_primary, load_safety, read_brake_cut
from pipeline.policies.network import (
    PrimaryNetwork,
    SafetyNetwork,
    feature_size,
    has_bfloat16,
    to_actions,
    to_float,
)

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
            ValueError: files are missing, of another kind of policy, or do not fit; `safety` watches
                another primary.
        """
        if safety is not None:
            check_pair(primary, safety)
        return cls(
            load_primary(primary),
            load_safety(safety) if safety is not None else None,
            brake_cut=read_brake_cut(primary),
            bfloat16=bfloat16,
        )

    def propose(self, seen: Mapping[str, np.ndarray]) -> tuple[np.ndarray, dict[str, float]]:
        """The primary's action for an observation by column, and what the policies say beside it.

        Returns:
            float32 [2]; and "safe_probability" [0, 1] where there is a safety policy.
        """
        action, conv5 = self.act(seen[CAMERA])
        return action, {"safe_probability": self.safe_probability(conv5)} if self.safety else {}

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
