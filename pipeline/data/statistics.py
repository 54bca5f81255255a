"""The statistics that LeRobot keeps of each column, of an episode and of a whole dataset.

Ours are exact, and of the finite values: NaN is not JSON, and says nothing.
In the shapes, E is the number of episodes, N of rows, D of numbers in each, and C of a picture's
channels.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Statistics = dict[str, NDArray]
"""By the names in NAMES: [E, D], of pictures [E, C] in [0, 1]; "count" is [E, 1], of pictures the
number of them. Where an episode has no value, its count is 0 and all else NaN."""

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
NAMES = ("min", "max", "mean", "std", "count", *QUANTILES)


def of_columns(
    columns: Mapping[str, NDArray], lengths: Sequence[int] | NDArray[np.int64]
) -> dict[str, Statistics]:
    """Of the rows without NaN of each column [N, *shape], whose episodes have `lengths` [E] rows."""
    lengths = np.asarray(lengths, np.int64)
    firsts = np.cumsum(lengths) - lengths
    flat = {n: v.reshape(len(v), math.prod(v.shape[1:])) for n, v in columns.items()}
    rows = np.concatenate([values.astype(np.float64) for values in flat.values()], axis=1)
    found = {name: np.empty((len(lengths), rows.shape[1])) for name in NAMES if name != "count"}
    # episodes of one length at once: NumPy takes longer to begin than to count
    for length in np.unique(lengths):
        those = np.flatnonzero(lengths == length)
        with np.errstate(invalid="ignore"):
            part = _of(rows[firsts[those, None] + np.arange(length)])
        for key, values in part.items():
            found[key][those] = values
    statistics: dict[str, Statistics] = {}
    start = 0
    for name, values in flat.items():
        stop = start + values.shape[1]
        own = {key: numbers[:, start:stop] for key, numbers in found.items()}
        statistics[name] = _of_finite(own, rows[:, start:stop], firsts, lengths)
        start = stop
    return statistics


def _of_finite(
    found: Statistics, rows: NDArray[np.float64], firsts: NDArray, lengths: NDArray
) -> Statistics:
    """The same of a column [N, D], and of its finite rows only where an episode has others."""
    finite = np.logical_and.reduce(np.isfinite(rows), axis=1)
    counts = np.add.reduceat(finite, firsts, dtype=np.int64) if len(firsts) else lengths
    for values in found.values():
        values[counts == 0] = np.nan
    for episode in np.flatnonzero((counts > 0) & (counts < lengths)):
        here = slice(firsts[episode], firsts[episode] + lengths[episode])
        for key, values in _of(rows[here][finite[here]][None]).items():
            found[key][episode] = values[0]
    return found | {"count": counts[:, None]}


def _of(rows: NDArray[np.float64]) -> Statistics:
    """Of the rows [E, N, D] of episodes of one length; all but their count."""
    lowest = rows.min(axis=1)
    above = (
        rows - lowest[:, None]
    )  # an id has 63 bits: equal ones must not differ by a rounding error
    quantiles = np.quantile(rows, list(QUANTILES.values()), axis=1)
    return {
        "min": lowest,
        "max": rows.max(axis=1),
        "mean": lowest + above.mean(axis=1),
        "std": above.std(axis=1),
        **dict(zip(QUANTILES, quantiles, strict=True)),
    }


def of_images(images: NDArray[np.uint8]) -> Statistics:
    """Of one episode's pictures [N, H, W, C], at least one."""
    channels = images.shape[-1]
    counts = np.zeros((channels, 256), np.int64)
    for image in images:
        for channel, count in enumerate(counts):
            count[:] += np.bincount(image[..., channel].ravel(), minlength=256)
    levels, total = np.arange(256) / 255, counts.sum(axis=1)
    mean = counts @ levels / total
    std = np.sqrt(np.maximum(counts @ levels**2 / total - mean**2, 0.0))
    below = np.cumsum(counts, axis=1) / total[:, None]
    shares = {**QUANTILES, "max": 1.0}
    at = {name: levels[(below >= share - 1e-12).argmax(axis=1)] for name, share in shares.items()}
    found = {**at, "min": levels[(counts > 0).argmax(axis=1)], "mean": mean, "std": std}
    return {name: values[None] for name, values in found.items()} | {
        "count": np.array([[len(images)]])
    }


def joined(parts: Sequence[Statistics]) -> Statistics:
    """Of the episodes of all `parts`, at least one, in that order."""
    return {name: np.concatenate([part[name] for part in parts]) for name in NAMES}


def aggregate(parts: Statistics) -> Statistics:
    """Of all pictures, from those of the episodes; quantiles are means, as LeRobot has them."""
    counts = parts["count"][:, 0].astype(float)
    shares = counts / counts.sum()
    mean = np.tensordot(shares, parts["mean"], 1)
    variance = np.tensordot(shares, parts["std"] ** 2 + (parts["mean"] - mean) ** 2, 1)
    found = {
        "min": parts["min"].min(axis=0),
        "max": parts["max"].max(axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": parts["count"].sum(axis=0),
        **{name: np.tensordot(shares, parts[name], 1) for name in QUANTILES},
    }
    return {name: values[None] for name, values in found.items()}


def with_placeholders(of_episodes: Statistics, overall: Statistics) -> Statistics:
    """Of episodes, those without a value among them filled.

    LeRobot's tools take the means of the episodes' statistics, weighted by their counts: nothing,
    or a count of zero, would have them divide by zero. Those of the whole dataset leave the
    aggregate as it is; zeros where it has no value either.
    """
    missing = of_episodes["count"] == 0
    of_all = {name: np.nan_to_num(values) for name, values in overall.items()} | {"count": 1}
    return {name: np.where(missing, of_all[name], of_episodes[name]) for name in NAMES}
