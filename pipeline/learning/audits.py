"""What a safety policy misses, estimated from audits: where nobody can look the reference up, it is
known of no other frame that the primary drove.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import nbinom

CONFIDENCE = 0.95


def estimated_recall(
    deviation: NDArray[np.floating],
    called: NDArray[np.bool_],
    audited: NDArray[np.bool_],
    share: float,
    tau: float,
) -> dict[str, float | None]:
    """The recall of unsafe frames in some drives, from what was asked in them alone.

    Each unsafe frame that was audited stands for 1 / `share` that the primary drove. The interval is
    of these very drives, in which audits alone are left to chance: one frame is audited or not
    whatever is of its neighbours. So it is exact, as for a share of a finite population, and it does
    not say how much other drives would differ.

    Args:
        deviation: [N], NaN where the reference was not asked; a frame is unsafe above `tau`.
        called: [N], the safety policy called it unsafe.
        audited: [N], it was asked to audit; else it was asked with certainty, or not.
        share: (0, 1], the probability of an audit of a frame that the primary drove.
        tau: the threshold.

    Returns:
        "audits": how many.
        "estimated_recall": of the unsafe frames, the share called unsafe, with the ends of its interval
            "estimated_recall_low" and "estimated_recall_high"; None where nothing unsafe was seen.
    """
    unsafe = deviation > tau
    found = int((unsafe & called & ~audited).sum())
    all_asked = int((unsafe & ~audited).sum())
    seen = int((unsafe & audited).sum())
    tail = (1 - CONFIDENCE) / 2
    # How many unsafe frames there were of which an audit may have seen so many: how many of them have
    # to pass before the last that it saw, and before one more, is negative binomial.
    fewest = seen + (nbinom.ppf(tail, seen, share) if seen else 0)
    most = seen + min(nbinom.ppf(1 - tail, seen + 1, share), np.isnan(deviation).sum())
    value, low, high = (
        found / (all_asked + missed) if all_asked + seen else None
        for missed in (seen / share, most, fewest)
    )
    return {
        "audits": int(audited.sum()),
        "estimated_recall": value,
        "estimated_recall_low": low,
        "estimated_recall_high": high,
    }
