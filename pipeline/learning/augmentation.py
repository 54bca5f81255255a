"""Colour jitter of a batch. In the shapes, B is the batch, H and W the image."""

import torch
from torch import Tensor


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
