"""What there is to say of a dataset, counted from its columns. N is the number of its rows."""

from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.ledger import collected
from pipeline.driving.affordances import FULL_ANGLE
from pipeline.driving.features import AFFORDANCES, CONTROL_HZ, FEATURES, IMITATED
from pipeline.driving.tracks import LANE_WIDTH
from pipeline.rollout.judgement import judgements


def dataset_facts(dataset: Dataset) -> dict[str, Any]:
    """Count a dataset of the car's; ValueError where it is another robot's.

    Returns:
        "total", and of each in "scenarios" (by task: track and traffic) and "iterations" (in which a
            frame was first recorded): episodes, frames, queries, frames that the reference drove.
        "judged": frames for which a safety policy gave its probability of safe; "taken_over", of
            these: the reference drove.
        "compared": frames of a rollout by a safety policy in which both actions are known;
            "deviating", of these: its labels call them unsafe; "unsafe_is": by which labels.
        "endings": drives that were recorded here, by how they ended; "collected": of these, what
            `ledger.collected` counts.
        "braking": frames whose action brakes.
        "offset": [m] from the middle of the lane, and "angle": [rad] to the lane, at most, in half and
            in 95 % of the frames; None without any.
        "cut_out": episodes that begin within a drive; "single": of one frame.
        "length": frames in an episode, and "ahead": actions from a frame to the end of its episode,
            its own counted; the medians, None without any.
        "columns": name, type and shape of each, and in how many frames it is NaN, "unknown".
    """
    dataset.require(IMITATED)
    columns = dataset.columns(n for n in dataset.with_core if n not in dataset.cameras)
    intervention = columns["intervention"][:, 0]
    judged = ~np.isnan(columns["safe_probability"][:, 0])
    affordances = columns["affordances"]
    drives = dataset.drives

    def counted(rows: NDArray[np.bool_]) -> dict[str, int]:
        return {
            "episodes": len(np.unique(dataset.episode_index[rows])),
            "frames": int(rows.sum()),
            "queries": int(columns["queried"][rows].sum()),
            "by_reference": int(intervention[rows].sum()),
        }

    def by(keys: NDArray) -> list[dict[str, Any]]:
        return [{"name": key, **counted(keys == key)} for key in np.unique(keys).tolist()]

    firsts, ends = np.array(dataset.bounds, int).reshape(-1, 2).T
    ahead = np.repeat(ends, dataset.lengths) - np.arange(len(dataset))
    return {
        "name": dataset.path.name,
        "fps": dataset.fps,
        "control_hz": CONTROL_HZ,
        "action_repeat": CONTROL_HZ // dataset.fps,
        "total": counted(np.ones(len(dataset), bool)),
        "scenarios": by(np.repeat(np.array(dataset.tasks, dtype=str), dataset.lengths)),
        "iterations": by(columns["source.iteration"][:, 0]),
        "judged": int(judged.sum()),
        "taken_over": int((judged & intervention).sum()),
        **_unsafe(dataset, columns),
        "endings": dict(Counter(drives.ended)) if len(drives) else {},
        "collected": collected(dataset) if len(drives) else {},
        "offset": _within(affordances[:, AFFORDANCES.index("lane_position")] * LANE_WIDTH / 2),
        "angle": _within(affordances[:, AFFORDANCES.index("lane_angle")] * FULL_ANGLE),
        "braking": int((columns["action"][:, 1] > 0).sum()),
        "cut_out": int((columns["source.frame"][firsts, 0] > 0).sum()),
        "single": int((dataset.lengths == 1).sum()),
        "length": _median(dataset.lengths),
        "ahead": _median(ahead),
        "columns": [
            {
                "name": name,
                "dtype": feature["dtype"],
                "shape": list(feature["shape"]),
                "unknown": _unknown(columns.get(name)),
            }
            for name, feature in FEATURES.items()
        ],
    }


def _unsafe(dataset: Dataset, columns: dict[str, NDArray]) -> dict[str, Any]:
    """Frames that can be compared, those of them that are unsafe, and by what labels."""
    compared = deviating = 0
    words = []
    for source, judgement in sorted(judgements(dataset.lineage).items()):
        rows = (columns["source.dataset"][:, 0] == source) & columns["queried"][:, 0]
        if rows.any():
            epsilon = judgement.deviation(columns["primary_action"][rows], columns["action"][rows])
            compared += int((~np.isnan(epsilon)).sum())
            deviating += int((epsilon > judgement.tau).sum())
            words.append(f"deviation of {judgement.words} above tau = {judgement.tau:g}")
    return {"compared": compared, "deviating": deviating, "unsafe_is": [*dict.fromkeys(words)]}


def _within(amount: NDArray[np.floating]) -> list[float] | None:
    """The sizes that half and that 95 % of `amount` [N] do not exceed."""
    return np.quantile(np.abs(amount), (0.5, 0.95)).tolist() if len(amount) else None


def _median(numbers: NDArray[np.int64]) -> float | None:
    return float(np.median(numbers)) if len(numbers) else None


def _unknown(values: NDArray | None) -> int:
    """Frames in which a column is NaN; of cameras it cannot be."""
    if values is None or values.dtype.kind != "f":
        return 0
    return int(np.isnan(values).any(axis=1).sum())
