"""What of a dataset a policy may imitate: the frames that have the reference's action."""

import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.pieces import chosen


def labelled(dataset: Dataset) -> tuple[list[tuple[int, int]], NDArray[np.int64]]:
    """The N rows that were `queried`, all that anything is learned from: of each run of neighbours among
    them, in one episode, the first row and the one after its last; and, [N], which run each is in, so
    that what lies around them, or between, makes no difference. ValueError where there are none.
    """
    runs = [(piece.start, piece.stop) for piece in chosen(dataset, dataset.column("queried"))]
    if not runs:
        raise ValueError(
            f"{dataset.path}: of {len(dataset)} frames none has a label of the reference, "
            "expected some to learn from"
        )
    return runs, np.repeat(np.arange(len(runs)), [stop - start for start, stop in runs])


def told(dataset: Dataset) -> list[str]:
    """What whoever learns from it should know of its labels, a line each."""
    if dataset.is_demonstrated:
        return [
            f"{dataset.path}: no column tells who drove, so all {len(dataset)} frames count as "
            "the reference's"
        ]
    without = int((~dataset.column("queried")).sum())
    of = f"{without} of {len(dataset)} frames have no label of the reference"
    return [f"{dataset.path}: {of}, and are not learned from"] if without else []
