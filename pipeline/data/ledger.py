"""What an iteration cost: frames driven, queries, and frames trained on, side by side.

Everything is counted from columns. A frame is a row: whoever drives is asked once in each, and its
action is held for the control steps that the row stands for.
"""

from itertools import compress

from pipeline.data.dataset import Dataset
from pipeline.data.identity import identities


def count(raw: Dataset, aggregate: Dataset) -> dict[str, int | float]:
    """Count one iteration.

    Args:
        raw: every frame driven in the iteration, before selection. In iteration 0 that is the
            aggregate itself: the reference's own driving. The paper leaves that out of the loop's
            queries.
        aggregate: D_i, what the iteration trains on.

    Returns:
        "frames_driven".
        "queries": frames for which the reference was asked for an action to drive or to train with.
        "frames_selected": frames driven whose labels the aggregate has taken in.
        "frames_trained": labelled frames of the aggregate: context around them is not trained on.
        "takeover": share of the driven frames in which the reference drove, [0, 1].
    """
    driven = raw.columns(["intervention", "queried"])
    trained = list(compress(identities(aggregate), aggregate.column("queried")))
    kept = set(trained)
    return {
        "frames_driven": len(driven["queried"]),
        "queries": int(driven["queried"].sum()),
        "frames_selected": sum(frame in kept for frame in identities(raw)),
        "frames_trained": len(trained),
        "takeover": float(driven["intervention"].mean()) if len(raw) else 0.0,
    }
