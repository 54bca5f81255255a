"""The loop: the budget, the two plans, and the episodes held out."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings, strategies

from pipeline.learning.fitting import cycle, fit, split_episodes
from pipeline.learning.settings import Optimisation
from pipeline.policies.computing import computing


def run(errors: list[float] | None = None, rows: int = 10, **fields):
    """Fit one weight to 1 and report what was shown, the rates and the weight after each epoch."""
    given = {"learning_rate": 0.1, "weight_decay": 0.0, "batch": 4, "validation": 0.1, **fields}
    optimisation = Optimisation(**given)
    network = torch.nn.Linear(1, 1, bias=False)
    torch.nn.init.zeros_(network.weight)
    shown, weights, epochs = [], [], []

    def loss_of(numbers: np.ndarray) -> torch.Tensor:
        shown.append(numbers.tolist())
        return (network.weight - 1).square().sum()

    def validate() -> dict[str, float]:
        weights.append(network.weight.item())
        return {"validation_loss": errors[len(weights) - 1]} if errors else {}

    metrics = fit(
        network,
        np.arange(100, 100 + rows),
        loss_of=loss_of,
        validate=validate,
        settings=optimisation,
        generator=torch.Generator().manual_seed(0),
        on_epoch=lambda epoch, of, _: epochs.append((epoch, of)),
    )
    return metrics, shown, weights, epochs, network.weight.item()


def test_so_many_examples_are_shown_whatever_the_size_of_the_dataset():
    metrics, shown, _, epochs, _ = run(optimizer="adamw", samples=25, rows=10)
    assert [len(batch) for batch in shown] == [4, 4, 2, 4, 4, 2, 4, 1]
    assert epochs == [(1, 3), (2, 3), (3, 3)]
    assert metrics["samples"] == 25 and metrics["epoch"] == 3
    for start in (0, 3):
        assert sorted(n for batch in shown[start : start + 3] for n in batch) == list(
            range(100, 110)
        )
    assert shown[:3] != shown[3:6]


def test_less_than_an_epoch_will_do():
    metrics, shown, _, epochs, _ = run(optimizer="adamw", samples=3, rows=10)
    assert [len(batch) for batch in shown] == [3]
    assert epochs == [(1, 1)]
    assert metrics["loss"] == 1


def test_sgd_divides_the_rate_stops_and_keeps_the_best_weights():
    errors = [1.0, 0.9, 0.95, 0.8, 0.85, 0.8, 0.86, 0.1]
    metrics, _, weights, epochs, weight = run(
        errors, optimizer="sgd", samples=800, rows=4, patience=3, learning_rate=0.001
    )
    assert len(epochs) == 7, "the fourth is the best, then three in a row are not better"
    assert metrics["epoch"] == 4 and metrics["validation_loss"] == 0.8
    assert metrics["samples"] == 16
    assert weight == weights[3]
    moves = np.diff([0.0, *weights])  # one step in each epoch; the gradient is close to -2
    assert moves[3] < moves[2] / 3, "divided by 5 after the third"
    assert moves[4] > moves[3], "not divided after the fourth, the momentum still grows"
    assert moves[5] < moves[4] / 3 and moves[6] < moves[5] / 3


def test_adamw_rises_and_falls_and_keeps_the_last_weights():
    errors = [1.0, 2.0, 3.0, 4.0, 5.0]
    metrics, _, weights, _, weight = run(errors, optimizer="adamw", samples=50, rows=10)
    assert weight == weights[-1]
    assert metrics["validation_loss"] == 5
    moves = np.abs(np.diff(weights))
    assert moves[-1] < moves[0] / 5


@given(strategies.integers(1, 300))
@settings(deadline=None)
def test_the_cycle_stays_within_its_highest_rate(steps):
    rates = [cycle(step, steps) for step in range(steps)]
    assert all(0 < rate <= 1 for rate in rates)
    if steps > 20:
        assert max(rates) > 0.95 and rates[0] < 0.2 and rates[-1] < 0.01


def test_a_loss_that_is_no_number_is_an_error():
    with pytest.raises(ValueError, match=r"learning_rate is 0\.1, expected a lower one"):
        run([float("nan")], optimizer="adamw", samples=10)


@given(
    strategies.lists(strategies.integers(0, 8), min_size=1, max_size=40),
    strategies.floats(0, 0.95),
    strategies.integers(0, 3),
)
def test_an_episode_is_never_divided(episodes, share, seed):
    index = np.array(episodes)
    if share and len(set(episodes)) < 2:
        with pytest.raises(ValueError, match="has 1 episodes, expected at least 2"):
            split_episodes(index, share, np.random.default_rng(seed))
        return
    rows, held_out = split_episodes(index, share, np.random.default_rng(seed))
    assert sorted([*rows, *held_out]) == list(range(len(episodes)))
    assert not set(index[rows]) & set(index[held_out])
    assert len(rows) > 0 and (len(held_out) > 0) == (share > 0)


def test_so_many_episodes_are_held_out():
    index = np.repeat(np.arange(20), 3)
    rows, held_out = split_episodes(index, 0.25, np.random.default_rng(0))
    assert (len(rows), len(held_out)) == (45, 15)


def test_no_rows_cannot_be_split():
    with pytest.raises(ValueError, match="has 0 episodes"):
        split_episodes(np.array([], int), 0.0, np.random.default_rng(0))


def test_the_threads_are_given_back():
    torch.set_num_threads(1)
    with pytest.raises(KeyError), computing(2):
        assert torch.get_num_threads() == 2
        raise KeyError
    assert torch.get_num_threads() == 1
