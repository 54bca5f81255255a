"""What an iteration cost: frames driven, queries, and frames trained on, side by side.

Everything is counted from columns. A frame is a row: whoever drives is asked once in each, and its
action is held for the control steps that the row stands for.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from pipeline.data.dataset import Dataset
from pipeline.data.identity import identities


@dataclass(frozen=True)
class Ledger:
    """The counts of one iteration, or of several (see `cumulative`)."""

    frames_driven: int
    """Frames driven."""
    queries: int
    """Frames for which the reference was asked for an action to drive or to train with."""
    frames_selected: int
    """Frames driven that the aggregate has taken in."""
    frames_trained: int
    """Frames of the aggregate."""
    takeover: float
    """Share of the driven frames in which the reference drove, [0, 1]."""

    def to_dict(self) -> dict[str, int | float]:
        """Plain numbers, for JSON."""
        return asdict(self)


def count(raw: Dataset, aggregate: Dataset) -> Ledger:
    """Count one iteration.

    Args:
        raw: every frame driven in the iteration, before selection. In iteration 0 that is the
            aggregate itself: the reference's own driving. The paper leaves that out of the loop's
            queries, so keep it out of `cumulative`, and report it apart.
        aggregate: D_i, what the iteration trains on.
    """
    driven = raw.columns(["intervention", "queried"])
    trained = identities(aggregate)
    kept = set(trained)
    return Ledger(
        frames_driven=len(driven["queried"]),
        queries=int(driven["queried"].sum()),
        frames_selected=sum(frame in kept for frame in identities(raw)),
        frames_trained=len(trained),
        takeover=float(driven["intervention"].mean()) if len(raw) else 0.0,
    )


def cumulative(iterations: Sequence[Ledger]) -> list[Ledger]:
    """Running totals over the iterations of a loop, one entry for each.

    Driven, queried and selected frames add up; the aggregate already holds all that came before,
    so `frames_trained` stays what it is; `takeover` becomes the share of all frames driven so far.
    """
    totals: list[Ledger] = []
    driven_by_reference = 0.0
    for now in iterations:
        before = totals[-1] if totals else Ledger(0, 0, 0, 0, 0.0)
        driven_by_reference += now.takeover * now.frames_driven
        frames_driven = before.frames_driven + now.frames_driven
        totals.append(
            Ledger(
                frames_driven=frames_driven,
                queries=before.queries + now.queries,
                frames_selected=before.frames_selected + now.frames_selected,
                frames_trained=now.frames_trained,
                takeover=driven_by_reference / frames_driven if frames_driven else 0.0,
            )
        )
    return totals
