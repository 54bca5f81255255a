"""The road as in a mirror, labels and all. In the shapes, B is the batch, H and W the image."""

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
