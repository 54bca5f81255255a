"""Colour jitter."""

import pytest
import torch

from pipeline.learning.augmentation import jitter


def test_jitter_moves_each_image_by_one_light():
    images = torch.rand(5, 3, 4, 6).mul_(0.2).add_(0.4)
    moved = jitter(images.clone(), 0.2, torch.Generator().manual_seed(0))
    assert not torch.equal(images, moved)
    assert moved.min() >= 0 and moved.max() <= 1
    for before, after in zip(images.flatten(0, 1), moved.flatten(0, 1), strict=True):
        # A colour of an image is scaled and moved as a whole: the ends give the line.
        x, y = before.flatten(), after.flatten()
        low, high = x.argmin(), x.argmax()
        slope = (y[high] - y[low]) / (x[high] - x[low])
        assert torch.allclose(y, y[low] + slope * (x - x[low]), atol=1e-5)
        assert 0.8 * 0.9 <= slope <= 1.2 * 1.1


def test_no_strength_is_no_jitter():
    images = torch.rand(2, 3, 4, 6)
    assert torch.allclose(jitter(images.clone(), 0.0, torch.Generator()), images)


def test_jitter_follows_its_generator():
    images = torch.rand(2, 3, 4, 6)
    first, again, other = (
        jitter(images.clone(), 0.3, torch.Generator().manual_seed(seed)) for seed in (1, 1, 2)
    )
    assert torch.equal(first, again) and not torch.equal(first, other)


@pytest.mark.parametrize("strength", [0.1, 0.9])
def test_jitter_never_leaves_the_range(strength):
    images = torch.rand(64, 3, 2, 2).round()
    moved = jitter(images, strength, torch.Generator().manual_seed(0))
    assert moved.min() >= 0 and moved.max() <= 1
