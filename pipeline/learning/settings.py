"""What a training is told: how to optimise."""

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Optimisation:
    """How a network is fitted. The same for the primary and the safety policy.

    `sgd` is the paper's: momentum, and after each epoch that did not improve the validation error
    the rate is divided by 5; `patience` such epochs in a row end the training, and the weights with
    the lowest error are kept. `adamw` follows one cycle: the rate rises and falls back to zero
    within `samples`, and the last weights are kept.

    Raises:
        ValueError: a field is out of the range stated beside it.
    """

    optimizer: Literal["sgd", "adamw"]
    learning_rate: float
    """> 0; the highest of the cycle for `adamw`."""
    weight_decay: float
    """>= 0."""
    samples: int
    """>= 1, examples shown in all: how long it may take, whatever the size of the dataset."""
    batch: int = 64
    """>= 1, examples in a step."""
    validation: float = 0.1
    """[0, 1), share of the episodes held out; `sgd` needs some."""
    patience: int = 3
    """>= 1, for `sgd` only: epochs in a row without improvement."""
    seed: int = 0
    """>= 0, of the initial weights, the order, the augmentation and the held-out episodes."""
    threads: int = 2
    """>= 1, processor threads."""
    bfloat16: bool = True
    """Whether convolutions may be computed in bfloat16, on processors that can."""

    def __post_init__(self) -> None:
        if self.optimizer not in ("sgd", "adamw"):
            raise ValueError(f"optimizer is {self.optimizer!r}, expected 'sgd' or 'adamw'")
        check("learning_rate", self.learning_rate, above=0)
        check("weight_decay", self.weight_decay, at_least=0)
        check("samples", self.samples, at_least=1)
        check("batch", self.batch, at_least=1)
        check("validation", self.validation, at_least=0, below=1)
        check("patience", self.patience, at_least=1)
        check("seed", self.seed, at_least=0)
        check("threads", self.threads, at_least=1)
        if self.optimizer == "sgd" and self.validation == 0:
            raise ValueError("validation is 0, expected more: 'sgd' follows the validation error")


@dataclass(frozen=True, kw_only=True)
class SafetySettings(Optimisation):
    """The training of a safety policy.

    Raises:
        ValueError: a field is out of the range stated beside it.
    """

    hidden: int
    """>= 1, width of each of the two hidden layers."""
    balance: float
    """[0, 1], class weights: 0 counts every frame alike, 1 both classes alike."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check("hidden", self.hidden, at_least=1)
        check("balance", self.balance, at_least=0, at_most=1)


def check(
    name: str,
    value: float,
    *,
    at_least: float = -math.inf,
    above: float = -math.inf,
    at_most: float = math.inf,
    below: float = math.inf,
) -> None:
    """Raise a one-line ValueError that names `name` unless `value` is finite and in the range."""
    if math.isfinite(value) and at_least <= value <= at_most and above < value < below:
        return
    bounds = {"at least": at_least, "above": above, "at most": at_most, "below": below}
    expected = " and ".join(f"{word} {b:g}" for word, b in bounds.items() if math.isfinite(b))
    raise ValueError(f"{name} is {value}, expected a number {expected}")
