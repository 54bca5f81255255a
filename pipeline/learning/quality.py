"""How well a safety policy tells unsafe frames, where the deviation is known."""

from typing import Any

import numpy as np
from scipy.stats import rankdata

from pipeline.metric import BINS


def detection_quality(
    safe_probability: np.ndarray, deviation: np.ndarray, tau: float, cut: float
) -> dict[str, Any]:
    """Measures of `safe_probability` [N] against `deviation` [N]; unsafe is what is to be found.

    A frame is unsafe where its deviation is above `tau`, and called so where its probability of being
    safe, [0, 1] or NaN, is not at least the cut. Frames whose deviation is not known are left out. A
    measure that is not defined is None. ValueError where the two differ in shape.

    Returns:
        "frames": how many were measured.
        "share_unsafe", "share_predicted_unsafe": of these frames.
        "recall": of the unsafe frames, the share called unsafe.
        "precision": of the frames called unsafe, the share that is.
        "auroc": the probability that a random unsafe frame gets a lower `safe_probability` than a
            random safe one, ties counting half; None unless there are both.
        "average_precision": the precision at each unsafe frame, ranked by probability, on average:
            the area below the steps of the precision-recall curve, ties counting as one step.
        "calibration_error": of BINS bins, how far the mean predicted probability of being unsafe is
            from the observed share, on average over the frames (Guo et al. 2017).
        "calibration": of each bin with frames [predicted, observed, frames].
    """
    if safe_probability.shape != deviation.shape:
        raise ValueError(
            f"safe_probability is {safe_probability.shape}, expected {deviation.shape} as deviation"
        )
    known = ~np.isnan(deviation)
    probability, unsafe = np.nan_to_num(safe_probability[known], nan=-1.0), deviation[known] > tau
    predicted = probability < cut
    bins = calibration(1 - probability.clip(0), unsafe)
    return {
        "frames": float(known.sum()),
        "share_unsafe": _share(unsafe),
        "share_predicted_unsafe": _share(predicted),
        "recall": _share(predicted[unsafe]),
        "precision": _share(unsafe[predicted]),
        "auroc": _auroc(-probability, unsafe),
        "average_precision": _average_precision(-probability, unsafe),
        "calibration_error": _calibration_error(bins),
        "calibration": bins,
    }


def calibration(unsafe_probability: np.ndarray, unsafe: np.ndarray) -> list[list[float]]:
    """Of each of BINS bins with frames: the mean probability of being unsafe, the share that is, and
    how many frames; `unsafe_probability` is [N] in [0, 1], `unsafe` bool [N].
    """
    # rounded first: 1 - 0.9 in float32 is a hair above 0.1
    numbers = np.minimum((BINS * unsafe_probability.round(6)).astype(int), BINS - 1)
    found = (numbers == number for number in np.unique(numbers))
    return [
        [float(unsafe_probability[here].mean()), float(unsafe[here].mean()), float(here.sum())]
        for here in found
    ]


def _calibration_error(bins: list[list[float]]) -> float | None:
    frames = sum(of[2] for of in bins)
    apart = sum(abs(predicted - observed) * count for predicted, observed, count in bins)
    return apart / frames if frames else None


def _average_precision(score: np.ndarray, positive: np.ndarray) -> float | None:
    """Of each distinct score, the precision above it times what it adds to the recall."""
    if not positive.any():
        return None
    order = np.argsort(-score, kind="stable")
    last = np.append(np.flatnonzero(np.diff(score[order])), len(score) - 1)
    found = np.cumsum(positive[order])[last]
    return float((found / (last + 1) * np.diff(found, prepend=0)).sum() / found[-1])


def _share(flags: np.ndarray) -> float | None:
    return float(flags.mean()) if len(flags) else None


def _auroc(score: np.ndarray, positive: np.ndarray) -> float | None:
    """Mann-Whitney: the mean rank of the positives, scaled to [0, 1]."""
    positives, negatives = int(positive.sum()), int((~positive).sum())
    if positives == 0 or negatives == 0:
        return None
    ranks = rankdata(score)[positive].sum()
    return float((ranks - positives * (positives + 1) / 2) / (positives * negatives))
