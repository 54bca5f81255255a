"""What an iteration cost: frames driven, queries, and frames trained on, side by side.

Everything is counted from columns. In the shapes, N is the number of rows of a dataset, and k the
control frames that a row stands for.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from pipeline.data.reading import check_dataset, read_columns

_SOURCE = ("source.iteration", "source.episode", "source.frame")


@dataclass(frozen=True)
class Ledger:
    """The counts of one iteration, or of several (see `cumulative`)."""

    frames_driven: int
    """Control frames driven."""
    queries: int
    """Control frames for which the reference was asked for an action to drive or to train with."""
    frames_selected: int
    """Rows driven that the aggregate has taken in."""
    frames_trained: int
    """Rows of the aggregate."""
    takeover: float
    """Share of the driven frames in which the reference drove, [0, 1]."""

    def to_dict(self) -> dict[str, int | float]:
        """Plain numbers, for JSON."""
        return asdict(self)


def row_queries(intervention: np.ndarray, queried: np.ndarray, record_every: int) -> np.ndarray:
    """Queries that each row cost.

    Where the reference drove it was asked in each of the row's `record_every` control frames;
    where it only labelled, once.

    Args:
        intervention: bool [N], the reference drove.
        queried: bool [N], the reference was asked.
        record_every: k.

    Returns:
        int64 [N].
    """
    return np.where(intervention, record_every, np.where(queried, 1, 0)).astype(np.int64)


def count(raw: Path | None, aggregate: Path) -> Ledger:
    """Count one iteration.

    Args:
        raw: every row driven in the iteration, before selection. None in iteration 0, where all
            that was driven is the aggregate itself: the reference's own driving. The paper leaves
            that out of the loop's queries, so keep it out of `cumulative`, and report it apart.
        aggregate: D_i, what the iteration trains on.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    driven_path = aggregate if raw is None else raw
    record_every = check_dataset(driven_path)
    driven = read_columns(driven_path, ["intervention", "queried", *_SOURCE])
    trained = read_columns(aggregate, _SOURCE)
    intervention = driven["intervention"][:, 0]
    kept = set(_identity(trained))
    queries = row_queries(intervention, driven["queried"][:, 0], record_every)
    return Ledger(
        frames_driven=record_every * len(intervention),
        queries=int(queries.sum()),
        frames_selected=sum(row in kept for row in _identity(driven)),
        frames_trained=len(trained["frame_index"]),
        takeover=float(intervention.mean()),
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
                takeover=driven_by_reference / frames_driven,
            )
        )
    return totals


def _identity(columns: dict[str, np.ndarray]) -> list[tuple[int, ...]]:
    """For each row, where it was first recorded."""
    return list(zip(*(columns[name][:, 0].tolist() for name in _SOURCE), strict=True))
