"""Mirroring and colour jitter."""

import pytest
import torch

from pipeline.learning.augmentation import jitter, mirror

ALL = torch.tensor([True])


def batch(rows: int = 8) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    images = torch.randint(0, 256, (rows, 4, 6, 3), generator=generator, dtype=torch.uint8)
    actions = torch.rand(rows, 2, generator=generator)
    return images, actions, torch.rand(rows, 10, generator=generator)


def test_a_mirror_swaps_left_and_right_in_the_image_and_in_every_label():
    images = torch.tensor([[[[1, 2, 3], [4, 5, 6], [7, 8, 9]]]], dtype=torch.uint8)
    actions = torch.tensor([[0.25, 1.0]])
    affordances = torch.tensor([[1.0, 0, 0, 1, 1, 60, 12, 30, 0.5, -0.1]])

    images, actions, affordances = mirror(images, actions, affordances, ALL)

    assert images.tolist() == [[[[7, 8, 9], [4, 5, 6], [1, 2, 3]]]]
    assert actions.tolist() == [[-0.25, 1.0]]
    expected = torch.tensor([[0.0, 1, 1, 1, 0, 30, 12, 60, -0.5, 0.1]])
    assert torch.equal(affordances, expected)


def test_a_mirror_in_a_mirror_shows_what_was():
    original, chosen = batch(), torch.rand(8) < 0.5
    twice = mirror(*mirror(*original, chosen), chosen)
    assert all(torch.equal(a, b) for a, b in zip(original, twice, strict=True))


def test_only_the_chosen_rows_are_mirrored():
    original, chosen = batch(4), torch.tensor([True, False, True, False])
    mirrored = mirror(*original, chosen)
    for before, after in zip(original, mirrored, strict=True):
        same = [torch.equal(a, b) for a, b in zip(before, after, strict=True)]
        assert same == [False, True, False, True]


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
