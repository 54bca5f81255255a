"""Algorithm 1, line 7: keep of a drive what the safety policy called unsafe."""

from collections.abc import Iterable, Iterator

import numpy as np

from pipeline.data.schema import Episode


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
    unsafe = np.concatenate([[False], safe_probability < cut, [False]])
    edges = np.flatnonzero(unsafe[1:] != unsafe[:-1])
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


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


def _check_cut(cut: float) -> None:
    if not 0 <= cut <= 1:
        raise ValueError(f"cut is {cut}, expected a probability in [0, 1]")
