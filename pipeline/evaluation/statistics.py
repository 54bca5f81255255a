"""Interquartile means, ratios of sums and shares of drives, and 95 % intervals of them.

In the shapes, N is the number of drives, K of columns, R of resamples.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

RESAMPLES = 2000
BOUNDS = (2.5, 97.5)
"""[%] of the resamples: where the interval begins and ends"""


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % interval."""

    value: float
    low: float
    """at most `value`"""
    high: float
    """at least `value`"""
    count: int
    """the drives, or pairs of drives, that it rests on"""


type Statistic = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""From columns (N, K) and how often each drive counts (R, N) to values (R,); NaN: not defined."""


def interquartile_mean(columns: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """The mean of the middle half of the values (N, 1), as `scipy.stats.trim_mean(values, 0.25)`, for
    each row of counts (R, N).
    """
    order = np.argsort(columns[:, 0], kind="stable")
    places = np.cumsum(counts[:, order], axis=1)
    total = places[:, -1:]
    cut = total // 4
    kept = np.diff(np.clip(places, cut, total - cut), axis=1, prepend=cut)
    return (kept * columns[order, 0]).sum(axis=1) / kept.sum(axis=1)


def ratio_of_sums(columns: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """All parts over all wholes, (N, 2), for each row of counts (R, N); NaN where the wholes are 0. Where each
    whole is 1, it is the mean.
    """
    parts, wholes = ((counts * column).sum(axis=1) for column in columns.T)
    return np.divide(parts, wholes, out=np.full(len(counts), np.nan), where=wholes > 0)


def estimate(
    statistic: Statistic,
    columns: np.ndarray,
    strata: Sequence[tuple[int, str]],
    generator: np.random.Generator,
) -> Estimate | None:
    """A statistic of some drives, N >= 1, from what it takes of each, (N, K); None where it is not defined.

    `strata` are the seed and the track of each drive. Equally seeded generators give equal intervals.
    """
    return _estimate(lambda counts: statistic(columns, counts), strata, generator)


def difference(
    statistic: Statistic,
    columns: np.ndarray,
    baseline: np.ndarray,
    strata: Sequence[tuple[int, str]],
    generator: np.random.Generator,
) -> Estimate | None:
    """A statistic of some drives minus that of their counterparts, resampled as pairs: row by row the
    same situation, driven otherwise. Else as `estimate`.
    """
    return _estimate(
        lambda counts: statistic(columns, counts) - statistic(baseline, counts), strata, generator
    )


def exact(successes: int, count: int) -> Estimate:
    """A share of independent drives, `count` >= 1, with its interval by Clopper and Pearson: unlike a
    bootstrap it knows of failures that did not happen.
    """
    from scipy.stats import binomtest  # takes a second, for which `results` need not wait

    ends = binomtest(successes, count).proportion_ci(method="exact")
    return Estimate(successes / count, float(ends.low), float(ends.high), count)


def _estimate(
    statistic: Callable[[np.ndarray], np.ndarray],
    strata: Sequence[tuple[int, str]],
    generator: np.random.Generator,
) -> Estimate | None:
    """The percentile interval, of the resamples in which the statistic is defined."""
    value = float(statistic(np.ones((1, len(strata)), dtype=int))[0])
    if np.isnan(value):
        return None
    low, high = np.nanpercentile(statistic(_resample(strata, generator)), BOUNDS)
    # a skewed sample, or rounding, must not leave the value outside
    return Estimate(value, min(float(low), value), max(float(high), value), len(strata))


def _resample(strata: Sequence[tuple[int, str]], generator: np.random.Generator) -> np.ndarray:
    """How often each drive is drawn, (R, N): first seeds, then drives of each drawn seed's tracks,
    or of all its tracks together where one of them has a single drive.

    `scipy.stats.bootstrap` knows no such levels. One less is drawn than there are (Rao and Wu
    1988), at both levels: with the usual number, two or three seeds or starts give intervals that
    are far too narrow. Of one alone nothing can be said: it is always drawn.
    """
    if min(Counter(strata).values()) == 1:
        strata = [(seed, "") for seed, _ in strata]
    seeds = sorted({seed for seed, _ in strata})
    drawn = dict(zip(seeds, _draw(np.ones(RESAMPLES, int), len(seeds), generator), strict=True))
    counts = np.empty((RESAMPLES, len(strata)), dtype=int)
    for stratum in sorted(set(strata)):
        members = [i for i, other in enumerate(strata) if other == stratum]
        counts[:, members] = _draw(drawn[stratum[0]], len(members), generator).T
    return counts


def _draw(times: np.ndarray, size: int, generator: np.random.Generator) -> np.ndarray:
    """How often each of `size` is drawn, (size, R), where they are resampled `times` (R,)."""
    return generator.multinomial(times * max(size - 1, 1), np.full(size, 1 / size)).T
