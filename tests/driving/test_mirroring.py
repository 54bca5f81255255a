"""Mirroring swaps left and right."""

import torch

from pipeline.driving.mirroring import mirror

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
