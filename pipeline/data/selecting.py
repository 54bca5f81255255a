"""What an iteration keeps of its drives: what the safety policy called unsafe (Algorithm 1, line 7),
or, for DAgger, a uniform sample (Sec. 4.2).
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from pipeline.data.reading import read_columns
from pipeline.data.schema import Episode


def runs(chosen: np.ndarray) -> list[slice]:
    """Maximal runs of true in `chosen` bool [T], in order."""
    padded = np.concatenate([[False], chosen, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def unsafe_runs(safe_probability: np.ndarray, cut: float) -> list[slice]:
    """Maximal runs of unsafe rows, in order.

    Args:
        safe_probability: [T], the safety policy's probability of safe. NaN, where there was no
            safety policy, is not unsafe.
        cut: a row is unsafe when its probability is below this, [0, 1].

    Raises:
        ValueError: `safe_probability` is not one-dimensional, or `cut` is outside [0, 1].
    """
    _check_cut(cut)
    if safe_probability.ndim != 1:
        raise ValueError(f"safe_probability has shape {safe_probability.shape}, expected (T,)")
    return runs(safe_probability < cut)


def check_unsafe(path: Path, cut: float) -> None:
    """Check that there is something to select in the dataset `path`.

    Raises:
        ValueError: no row was judged by a safety policy, or none has a probability below `cut`; or
            as `check_dataset`.
        FileNotFoundError: as `check_dataset`.
    """
    probability = read_columns(path, ["safe_probability"])["safe_probability"]
    if np.isnan(probability).all():
        raise ValueError(f"{path}: no safe_probability, expected a rollout by the safe strategy")
    if not (probability < cut).any():
        raise ValueError(f"{path}: no frame has a safe_probability below the cut, {cut:g}")


def select_unsafe(episodes: Iterable[Episode], cut: float) -> Iterator[Episode]:
    """Each run of unsafe rows as an episode of its own, so that no episode has a gap in time.

    Raises:
        ValueError: `cut` is outside [0, 1]; at once, before the first episode is asked for.
    """
    _check_cut(cut)
    return (
        episode.rows(run.start, run.stop)
        for episode in episodes
        for run in unsafe_runs(episode.columns["safe_probability"][:, 0], cut)
    )


def sample_frames(
    episodes: Iterable[Episode], total: int, frames: int, rng: np.random.Generator
) -> Iterator[Episode]:
    """A uniform sample of `frames` rows of the `total` that `episodes` have, without replacement.

    Each run of neighbours is an episode of its own, so that no episode has a gap in time.

    Raises:
        ValueError: `frames` is not from 1 to `total`; at once.
    """
    if not 1 <= frames <= total:
        raise ValueError(f"frames is {frames}, expected 1 to the {total} of the dataset")
    chosen = np.zeros(total, bool)
    chosen[rng.choice(total, frames, replace=False)] = True
    return _sampled(episodes, chosen)


def _sampled(episodes: Iterable[Episode], chosen: np.ndarray) -> Iterator[Episode]:
    first = 0
    for episode in episodes:
        for run in runs(chosen[first : first + len(episode)]):
            yield episode.rows(run.start, run.stop)
        first += len(episode)


def _check_cut(cut: float) -> None:
    if not 0 <= cut <= 1:
        raise ValueError(f"cut is {cut}, expected a probability in [0, 1]")
