"""How well a safety policy tells unsafe frames, where the deviation is known."""

import numpy as np
from scipy.stats import rankdata


def detection_quality(
    safe_probability: np.ndarray, deviation: np.ndarray, tau: float, cut: float
) -> dict[str, float | None]:
    """Measures of `safe_probability` [N] against `deviation` [N]; unsafe is what is to be found.

    Frames whose deviation is not known are left out. A measure that is not defined is None.

    Args:
        safe_probability: [N] in [0, 1], the probability of being safe (Eq. 2); NaN is unsafe.
        deviation: [N], a frame is unsafe where it is above `tau`.
        tau: the threshold.
        cut: a frame is called unsafe where its probability is below this.

    Returns:
        "frames": how many were measured.
        "share_unsafe", "share_predicted_unsafe": of these frames.
        "recall": of the unsafe frames, the share called unsafe.
        "precision": of the frames called unsafe, the share that is.
        "auroc": the probability that a random unsafe frame gets a lower `safe_probability` than a
            random safe one, ties counting half; None unless there are both.

    Raises:
        ValueError: the arrays differ in shape.
    """
    if safe_probability.shape != deviation.shape:
        raise ValueError(
            f"safe_probability is {safe_probability.shape}, expected {deviation.shape} as deviation"
        )
    known = ~np.isnan(deviation)
    probability, unsafe = np.nan_to_num(safe_probability[known], nan=-1.0), deviation[known] > tau
    predicted = probability < cut
    return {
        "frames": float(known.sum()),
        "share_unsafe": _share(unsafe),
        "share_predicted_unsafe": _share(predicted),
        "recall": _share(predicted[unsafe]),
        "precision": _share(unsafe[predicted]),
        "auroc": _auroc(-probability, unsafe),
    }


def _share(flags: np.ndarray) -> float | None:
    return float(flags.mean()) if len(flags) else None


def _auroc(score: np.ndarray, positive: np.ndarray) -> float | None:
    """Mann-Whitney: the mean rank of the positives, scaled to [0, 1]."""
    positives, negatives = int(positive.sum()), int((~positive).sum())
    if positives == 0 or negatives == 0:
        return None
    ranks = rankdata(score)[positive].sum()
    return float((ranks - positives * (positives + 1) / 2) / (positives * negatives))
