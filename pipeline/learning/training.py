"""Lines 3, 4, 9 and 10 of Algorithm 1: training a primary policy, and its safety policy.

The same arguments give the same weights, bit by bit, on the same machine.
In the shapes, N is the number of frames.
"""

import math
from collections.abc import Mapping

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from pipeline.data.schema import Feature, column_dtype
from pipeline.learning.augmentation import jitter
from pipeline.learning.fitting import Metrics, OnEpoch, fit, split_episodes
from pipeline.learning.labels import safe_labels
from pipeline.learning.settings import Optimisation, SafetySettings
from pipeline.policies.computing import CPU, computing
from pipeline.policies.lesson import Lesson
from pipeline.policies.network import ConvNetwork, SafetyNetwork, has_bfloat16, to_float

Batch = dict[str, Tensor]
"""Columns [B, ...] by name."""

EXTREME = 6.0
"""Of log(deviation / tau): what is 400 times smaller or larger than tau differs no more."""

_MEASURED = 256
"""Held-out frames that are measured at a time."""


def train_primary(
    lesson: Lesson,
    features: Mapping[str, Feature],
    columns: Mapping[str, np.ndarray],
    episode_index: np.ndarray,
    settings: Optimisation,
    *,
    initial: Mapping[str, Tensor] | None = None,
    device: torch.device = CPU,
    on_epoch: OnEpoch | None = None,
) -> tuple[ConvNetwork, Metrics]:
    """Train a primary policy to imitate the reference (Eq. 1); ValueError for arrays of the wrong shape,
    type or length, or `initial` of another network.

    Args:
        features: what the lesson has `learned` of a dataset.
        columns: all of `features`, [N, *shape]; images are uint8.
        episode_index: int [N]; frames of the same one are held out together.
        initial: the `state_dict` of such a network to begin with; None begins from scratch.
        device: that computes. The processor draws and augments, so that chance is the same on all.

    Returns:
        The network in evaluation mode, on the CPU, and metrics: "epoch", "samples", "loss" (of
        training), and with held-out frames "validation_loss" and its unweighted parts, by the
        lesson's names.
    """
    _check_rows(
        episode_index=(episode_index, np.integer, ()),
        **{
            name: (columns[name], column_dtype(of).type, of["shape"])
            for name, of in features.items()
        },
    )
    generator = torch.Generator().manual_seed(settings.seed)
    rng = np.random.default_rng(settings.seed)
    rows, held_out = split_episodes(episode_index, settings.validation, rng)
    network = lesson.network(features, columns, generator)
    if initial is not None:
        _begin_with(network, initial)
    network.to(device)
    kind = torch.bfloat16 if settings.bfloat16 and has_bfloat16(device) else torch.float32

    def losses(bright: Tensor, shown: Batch) -> tuple[Tensor, dict[str, Tensor]]:
        moved = {name: column.to(device) for name, column in shown.items()}
        seen = network.features(bright.to(device), kind)
        return lesson.loss(network, network.join(seen.float(), moved), moved)

    def batch(numbers: np.ndarray) -> Batch:
        return {name: torch.from_numpy(columns[name][numbers]) for name in features}

    def loss_of(numbers: np.ndarray) -> Tensor:
        shown = lesson.augment(batch(numbers), generator)
        bright = to_float(shown[network.camera])
        if lesson.jitter:
            bright = jitter(bright, lesson.jitter, generator)
        return losses(bright, shown)[0]

    @torch.inference_mode()
    def validate() -> Metrics:
        sums: dict[str, float] = {}
        for numbers in _chunks(held_out):
            shown = batch(numbers)
            loss, parts = losses(to_float(shown[network.camera]), shown)
            for name, value in {"loss": loss, **parts}.items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(numbers)
        return {f"validation_{name}": value / len(held_out) for name, value in sums.items()}

    with computing(settings.threads):
        metrics = fit(network, rows, loss_of, validate, settings, generator, on_epoch)
    return network.cpu(), metrics


def train_safety(
    features: np.ndarray,
    deviation: np.ndarray,
    episode_index: np.ndarray,
    settings: SafetySettings,
    *,
    weight: np.ndarray | None = None,
    device: torch.device = CPU,
    on_epoch: OnEpoch | None = None,
) -> tuple[SafetyNetwork, Metrics]:
    """Train a safety policy to tell safe from unsafe frames (Eq. 4), from the primary's Conv5; ValueError
    for arrays of the wrong shape, type or length, or a NaN.

    Where it learns the size of the deviation, it regresses log(deviation / tau), at most `EXTREME` on
    either side, as the difference of its logits: the probability of being safe is then
    tau / (tau + what it expects), one half where that is tau.

    Args:
        features: float16 or float32 [N, F], as `inference.propose` gives them.
        deviation: float [N], no NaN: how far the primary is from the reference, see Eq. 2.
        episode_index: int [N]; frames of the same one are held out together.
        weight: float [N], above 0, for how many frames each counts; 1 for each where None.
        device: that computes.
        on_epoch: see `fitting.OnEpoch`.

    Returns:
        The network in evaluation mode, on the CPU, and metrics: "epoch", "samples", "loss" (of
        training), and with held-out frames "validation_loss". Both losses have the weights in them
        that there are: of frames and, where it learns whether they are unsafe, of the classes.
    """
    weight = np.ones(len(deviation)) if weight is None else weight
    _check_rows(
        features=(features, np.floating, features.shape[-1:]),
        deviation=(deviation, np.floating, ()),
        episode_index=(episode_index, np.integer, ()),
        weight=(weight, np.floating, ()),
    )
    generator = torch.Generator().manual_seed(settings.seed)
    rng = np.random.default_rng(settings.seed)
    rows, held_out = split_episodes(episode_index, settings.validation, rng)
    network = SafetyNetwork(features.shape[1], settings.hidden, generator=generator)
    network.to(device)
    safe = safe_labels(deviation, settings.tau)
    counts = torch.from_numpy(weight / weight[rows].mean()).float().to(device)
    weights = class_weights(safe[rows], settings.balance, weight[rows]).to(device)

    def loss_of(numbers: np.ndarray) -> Tensor:
        logits = network(torch.from_numpy(features[numbers]).to(device))
        if settings.learns == "size":
            sizes = log_sizes(deviation[numbers], settings.tau).to(device)
            return ((logits[:, 0] - logits[:, 1] - sizes).square() * counts[numbers]).mean()
        labels = torch.from_numpy(safe[numbers]).long().to(device)
        each = F.cross_entropy(logits, labels, reduction="none")
        return (each * weights[labels] * counts[numbers]).mean()

    @torch.inference_mode()
    def validate() -> Metrics:
        if len(held_out) == 0:
            return {}
        total = sum(float(loss_of(chunk)) * len(chunk) for chunk in _chunks(held_out))
        return {"validation_loss": total / len(held_out)}

    with computing(settings.threads):
        metrics = fit(network, rows, loss_of, validate, settings, generator, on_epoch)
    return network.cpu(), metrics


@torch.inference_mode()
def safe_probabilities(network: SafetyNetwork, features: np.ndarray) -> np.ndarray:
    """The probability float32 [N] that the primary is safe (Eq. 2), of `features` [N, F]."""
    probabilities = np.empty(len(features), np.float32)
    for rows in _chunks(np.arange(len(features))):
        probabilities[rows] = network(torch.from_numpy(features[rows])).softmax(1)[:, 1].numpy()
    return probabilities


def class_weights(safe: np.ndarray, balance: float, weight: np.ndarray | None = None) -> Tensor:
    """Weights float32 [2] of unsafe (index 0) and safe frames, 1 on average over the frames.

    A class counts in inverse proportion to its share raised to `balance`: 0 counts each frame
    alike, 1 each class alike. With one class only, both weigh 1. `safe` is bool [N], and `weight` [N] as
    for `train_safety`.
    """
    shares = np.average([~safe, safe], axis=1, weights=weight)
    if 0 in shares:
        return torch.ones(2)
    weights = shares**-balance
    return torch.from_numpy(weights / (shares * weights).sum()).float()


def log_sizes(deviation: np.ndarray, tau: float) -> Tensor:
    """log(deviation / tau), float32 [N] within +-`EXTREME`: above 0 where a frame is unsafe."""
    with np.errstate(divide="ignore"):
        sizes = np.log(deviation / tau).clip(-EXTREME, EXTREME)
    return torch.from_numpy(sizes).float()


def _begin_with(network: ConvNetwork, initial: Mapping[str, Tensor]) -> None:
    try:
        network.load_state_dict(initial)
    except RuntimeError as error:
        raise ValueError(
            f"initial does not fit a primary of {network.channels} channels: "
            f"{' '.join(str(error).split())}"
        ) from None


def _check_rows(**arrays: tuple[np.ndarray, type, tuple[int, ...]]) -> None:
    """Raise a one-line ValueError unless each array has its type, shape [N, *shape] and one N."""
    rows = len(next(iter(arrays.values()))[0])
    for name, (array, dtype, shape) in arrays.items():
        if not np.issubdtype(array.dtype, dtype) or array.shape != (rows, *shape) or rows == 0:
            raise ValueError(
                f"{name} is {array.dtype} {array.shape}, "
                f"expected {dtype.__name__} {(max(rows, 1), *shape)}"
            )


def _chunks(rows: np.ndarray) -> list[np.ndarray]:
    return np.array_split(rows, math.ceil(len(rows) / _MEASURED)) if len(rows) else []
