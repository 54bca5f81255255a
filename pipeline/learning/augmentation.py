"""Colour jitter and mirroring of a batch. In the shapes, B is the batch, H and W the image."""

import torch
from torch import Tensor

from pipeline.driving.features import AFFORDANCES

_OTHER_SIDE = {
    "lane_left": "lane_right",
    "car_left": "car_right",
    "distance_left": "distance_right",
}
_BOTH_WAYS = _OTHER_SIDE | {right: left for left, right in _OTHER_SIDE.items()}
_MIRRORED = [AFFORDANCES.index(_BOTH_WAYS.get(name, name)) for name in AFFORDANCES]
_SIGNS = torch.tensor([-1.0 if n in ("lane_position", "lane_angle") else 1.0 for n in AFFORDANCES])


def mirror(
    images: Tensor, actions: Tensor, affordances: Tensor, chosen: Tensor
) -> tuple[Tensor, Tensor, Tensor]:
    """Swap left and right in the rows that `chosen` [B] marks, in images and labels alike.

    Steering, lane position and lane angle change their sign; the brake stays. Twice is once
    around: the same rows mirrored again are as before.

    Args:
        images: [B, H, W, 3] of any type.
        actions: [B, 2].
        affordances: [B, 10].
        chosen: bool [B].
    """
    row = chosen[:, None]
    images = torch.where(row[:, None, None], images.flip(2), images)
    actions = torch.where(row, actions * torch.tensor([-1.0, 1.0]), actions)
    affordances = torch.where(row, affordances[:, _MIRRORED] * _SIGNS, affordances)
    return images, actions, affordances


def jitter(images: Tensor, strength: float, generator: torch.Generator) -> Tensor:
    """Another light on each of `images` float [B, 3, H, W] in [0, 1], in place.

    Contrast is scaled by up to 1 +- strength around mid-grey, each colour by half as much, and the
    brightness moved by up to half of the strength; then cut to [0, 1].
    """
    draws = torch.rand(len(images), 5, generator=generator).mul_(2).sub_(1).mul_(strength)
    contrast, brightness, colours = draws[:, :1], draws[:, 1:2] / 2, draws[:, 2:] / 2
    gain = (1 + contrast) * (1 + colours)
    offset = brightness - contrast / 2
    return images.mul_(gain[..., None, None]).add_(offset[..., None, None]).clamp_(0, 1)
