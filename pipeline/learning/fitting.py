"""Fitting a network: the loop that the primary and the safety policy share, and its two plans."""

import copy
import math
from collections.abc import Callable
from typing import Protocol

import numpy as np
import torch
from torch import Tensor, nn

from pipeline.learning.settings import Optimisation

Metrics = dict[str, float]
OnEpoch = Callable[[int, int, Metrics], None]
"""Called after each epoch with its number from 1, how many there are at most, and its metrics."""

MOMENTUM = 0.9
RATE_DIVISOR = 5
"""Both the paper's, for `sgd`."""
WARM_UP = 0.2
"""Share of the cycle in which the rate rises, for `adamw`."""


def fit(
    network: nn.Module,
    rows: np.ndarray,
    loss_of: Callable[[np.ndarray], Tensor],
    validate: Callable[[], Metrics],
    settings: Optimisation,
    generator: torch.Generator,
    on_epoch: OnEpoch | None,
) -> Metrics:
    """Fit `network` in place and return the metrics of the epoch whose weights it has; ValueError where the
    loss is no longer a number.

    Args:
        network: on any device; left in evaluation mode, with its last (`adamw`) or its best (`sgd`)
            weights.
        rows: int [N], numbers of the training examples.
        loss_of: the mean loss of the examples with these numbers.
        validate: metrics of held-out examples; `sgd` needs "validation_loss" among them.
        generator: of the order of the examples; it is advanced.
        on_epoch: see `OnEpoch`; the last epoch may be cut short by `settings.samples`.
    """
    epochs = math.ceil(settings.samples / len(rows))
    plan: _Plan = (_Plateau if settings.optimizer == "sgd" else _Cycle)(network, settings, rows)
    samples, device = 0, next(network.parameters()).device
    for epoch in range(1, epochs + 1):
        order = rows[torch.randperm(len(rows), generator=generator).numpy()]
        order = order[: settings.samples - samples]
        network.train()
        total = torch.zeros((), device=device)
        for start in range(0, len(order), settings.batch):
            batch = order[start : start + settings.batch]
            plan.optimizer.zero_grad()
            loss = loss_of(batch)
            loss.backward()
            plan.step()
            total += loss.detach() * len(batch)
        network.eval()
        samples += len(order)
        metrics = {"epoch": epoch, "samples": samples, "loss": float(total) / len(order)}
        metrics |= validate()
        if not all(math.isfinite(value) for value in metrics.values()):
            raise ValueError(
                f"learning_rate is {settings.learning_rate:g}, expected a lower one: "
                f"the loss in epoch {epoch} is no longer a number"
            )
        if on_epoch is not None:
            on_epoch(epoch, epochs, metrics)
        if plan.ends(metrics):
            break
    return plan.finish()


class _Plan(Protocol):
    """How the rate moves, when the training ends, and which weights are kept."""

    optimizer: torch.optim.Optimizer

    def __init__(self, network: nn.Module, settings: Optimisation, rows: np.ndarray) -> None: ...

    def step(self) -> None:
        """Move the weights."""

    def ends(self, metrics: Metrics) -> bool:
        """Whether the epoch with these metrics was the last."""

    def finish(self) -> Metrics:
        """Leave the network with the weights to keep; return the metrics of their epoch."""


class _Cycle(_Plan):
    """AdamW with one cycle of the rate over all steps; the last weights are kept."""

    def __init__(self, network: nn.Module, settings: Optimisation, rows: np.ndarray) -> None:
        self.optimizer = torch.optim.AdamW(
            network.parameters(), weight_decay=settings.weight_decay, fused=True
        )
        self.highest = settings.learning_rate
        whole, rest = divmod(settings.samples, len(rows))
        self.steps = sum(math.ceil(n / settings.batch) for n in [len(rows)] * whole + [rest])
        self.taken = 0

    def step(self) -> None:
        _set_rate(self.optimizer, self.highest * cycle(self.taken, self.steps))
        self.optimizer.step()
        self.taken += 1

    def ends(self, metrics: Metrics) -> bool:
        self.last = metrics
        return False

    def finish(self) -> Metrics:
        return self.last


class _Plateau(_Plan):
    """The paper's SGD: the rate is divided where the validation error stops improving."""

    def __init__(self, network: nn.Module, settings: Optimisation, rows: np.ndarray) -> None:
        self.optimizer = torch.optim.SGD(
            network.parameters(),
            lr=settings.learning_rate,
            momentum=MOMENTUM,
            weight_decay=settings.weight_decay,
            fused=True,
        )
        self.network = network
        self.rate = settings.learning_rate
        self.patience = self.left = settings.patience
        self.best: Metrics = {"validation_loss": math.inf}

    def step(self) -> None:
        self.optimizer.step()

    def ends(self, metrics: Metrics) -> bool:
        if metrics["validation_loss"] < self.best["validation_loss"]:
            self.best = metrics
            self.weights = copy.deepcopy(self.network.state_dict())
            self.left = self.patience
            return False
        self.rate /= RATE_DIVISOR
        _set_rate(self.optimizer, self.rate)
        self.left -= 1
        return self.left == 0

    def finish(self) -> Metrics:
        self.network.load_state_dict(self.weights)
        return self.best


def cycle(step: int, steps: int) -> float:
    """Share of the highest rate at `step` of `steps`: up in a line, down in half a cosine."""
    done = (step + 0.5) / steps
    if done < WARM_UP:
        return done / WARM_UP
    return 0.5 * (1 + math.cos(math.pi * (done - WARM_UP) / (1 - WARM_UP)))


def split_episodes(
    episode_index: np.ndarray, share: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of `episode_index`, int [N], to train on and rows to hold out, both in order: a share [0, 1) of
    the episodes, at least one where it is above 0, and never a part of one. ValueError where there are
    fewer than two episodes to share out, or no rows.
    """
    episodes = np.unique(episode_index)
    if len(episodes) < (2 if share else 1):
        raise ValueError(
            f"episode_index has {len(episodes)} episodes, expected at least {2 if share else 1}"
        )
    held_out = min(max(math.ceil(share * len(episodes)), 1), len(episodes) - 1) if share else 0
    chosen = np.isin(episode_index, rng.permutation(episodes)[:held_out])
    return np.flatnonzero(~chosen), np.flatnonzero(chosen)


def _set_rate(optimizer: torch.optim.Optimizer, rate: float) -> None:
    for group in optimizer.param_groups:
        group["lr"] = rate
