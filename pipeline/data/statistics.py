"""The statistics that LeRobot keeps of each column, of an episode and of a whole dataset.

Ours are exact, and of the finite values: NaN is not JSON, and says nothing.
In the shapes, N is the number of rows, D of numbers in each, and C of a picture's channels.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Statistics = dict[str, list[Any]]
"""By the names in NAMES: a list of D numbers, of pictures C times [[number]]; "count" is one."""

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
NAMES = ("min", "max", "mean", "std", "count", *QUANTILES)


def of_columns(columns: dict[str, NDArray]) -> dict[str, Statistics | None]:
    """Of the rows without NaN of each column [N, *shape]; None where there is no such row."""
    found: dict[str, Statistics | None] = {}
    whole: dict[str, NDArray] = {}
    for name, values in columns.items():
        rows = values.reshape(len(values), -1).astype(np.float64)
        finite = np.isfinite(rows).all(axis=1)
        if finite.all() and len(rows):
            whole[name] = rows
        else:
            found[name] = _of(rows[finite]) if finite.any() else None
    # all at once: an episode has twenty columns, and NumPy takes longer to begin than to count
    together = _of(np.concatenate(list(whole.values()), axis=1)) if whole else {}
    first = 0
    for name, numbers_of in whole.items():
        stop = first + numbers_of.shape[1]
        found[name] = {
            key: numbers if key == "count" else numbers[first:stop]
            for key, numbers in together.items()
        }
        first = stop
    return found


def _of(rows: NDArray[np.float64]) -> Statistics:
    quantiles = np.quantile(rows, list(QUANTILES.values()), axis=0).tolist()
    lowest = rows.min(axis=0)
    above = rows - lowest  # an id has 63 bits: equal ones must not differ by a rounding error
    return {
        "min": lowest.tolist(),
        "max": rows.max(axis=0).tolist(),
        "mean": (lowest + above.mean(axis=0)).tolist(),
        "std": above.std(axis=0).tolist(),
        "count": [len(rows)],
        **dict(zip(QUANTILES, quantiles, strict=True)),
    }


def of_images(images: Sequence[NDArray[np.uint8]]) -> Statistics:
    """Of pictures [H, W, C], at least one; numbers in [0, 1], and "count" is of pictures."""
    counts = np.zeros((images[0].shape[-1], 256), np.int64)
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
    nested = {name: values[:, None, None].tolist() for name, values in found.items()}
    return {**nested, "count": [len(images)]}


def aggregate(parts: Sequence[Statistics]) -> Statistics:
    """Of pictures, from those of the episodes; quantiles are means, as LeRobot has them."""
    counts = np.array([part["count"][0] for part in parts], float)
    shares = counts / counts.sum()
    arrays = {name: np.array([part[name] for part in parts]) for name in NAMES if name != "count"}
    mean = np.tensordot(shares, arrays["mean"], 1)
    variance = np.tensordot(shares, arrays["std"] ** 2 + (arrays["mean"] - mean) ** 2, 1)
    return {
        "min": arrays["min"].min(axis=0).tolist(),
        "max": arrays["max"].max(axis=0).tolist(),
        "mean": mean.tolist(),
        "std": np.sqrt(variance).tolist(),
        "count": [int(counts.sum())],
        **{name: np.tensordot(shares, arrays[name], 1).tolist() for name in QUANTILES},
    }


def placeholder(overall: Statistics | None, numbers: int) -> Statistics:
    """Of an episode without a value in a column of `numbers` numbers a row.

    LeRobot's tools take the means of the episodes' statistics, weighted by their counts: nothing,
    or a count of zero, would have them divide by zero. Those of the whole dataset leave the
    aggregate as it is; zeros where it has no value either.
    """
    zeros = {name: [0.0] * numbers for name in NAMES}
    return {**(overall or zeros), "count": [1]}
