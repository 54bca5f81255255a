"""What an iteration cost, side by side: frames driven, queries, frames trained on, and what became
of the drives.

All but how the drives ended is counted from columns. A frame is a row: whoever drives is asked once
in each, and its action is held for the control steps that the row stands for.
"""

from collections.abc import Mapping
from itertools import compress
from typing import cast

import numpy as np
import pandas as pd

from pipeline.data.dataset import Dataset
from pipeline.data.identity import identities
from pipeline.data.schema import Asked
from pipeline.metric import FAILURE
from pipeline.task import load_task


def count(raw: Dataset, aggregate: Dataset) -> dict[str, int | float | None]:
    """Count one iteration: every frame driven in it, before selection (`raw`), and D_i, which it trains on
    (`aggregate`). In iteration 0 both are the same, the reference's own driving, which the paper leaves
    out of the loop's queries.

    Beside what `collected` counts, and raises, "frames_driven";
        "queries": frames for which the reference was asked for an action to drive or to train with;
        "frames_selected": frames driven whose labels the aggregate has taken in;
        "frames_trained": labelled frames of the aggregate: context around them is not trained on;
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
        **collected(raw),
    }


def collected(raw: Dataset) -> dict[str, int | None]:
    """What the drives of a dataset, an episode each, took, and what became of them. ValueError where
    nobody knows the task that was driven.

    Returns:
        "calls": how often the reference was called to drive, for "frames_of_calls" in all.
        "switches": how often the driver changed within a drive, either way.
        "drives", and "scenarios": the different ones that they were in.
        "audits": frames asked to learn what the safety policy misses.
        "put_back": drives after which somebody had to put the robot back.
        "failures": of all kinds that the task names, and of each "failures.<name>".
        None where a dataset does not tell how its drives ended, or its task what a failure is.
    """
    columns = raw.columns(["intervention", "asked_because"])
    drove = columns["intervention"][:, 0]
    begins = np.zeros(len(raw), bool)
    begins[[start for start, _ in raw.bounds]] = True
    before = np.concatenate([[False], drove])[:-1]
    return {
        "calls": int((drove & (begins | ~before)).sum()),
        "frames_of_calls": int(drove.sum()),
        "switches": int(((drove != before) & ~begins).sum()),
        "drives": len(raw.lengths),
        "scenarios": len(set(raw.tasks)),
        "audits": int((columns["asked_because"] == Asked.AUDIT).sum()),
        **_ends(raw.drives, _failures(raw)),
    }


def _failures(raw: Dataset) -> Mapping[str, str]:
    """As the task that was driven names them; none where nobody wrote down which it was."""
    task = raw.lineage.own.arguments.get("task")
    return load_task(task).failures if task else {}


def _ends(drives: pd.DataFrame, failures: Mapping[str, str]) -> dict[str, int | None]:
    found = {FAILURE + name: _sum(drives, told) for name, told in failures.items()}
    known = [number for number in found.values() if number is not None]
    complete = failures and len(known) == len(found)
    return {
        "put_back": _sum(drives, "put_back"),
        "failures": sum(known) if complete else None,
        **found,
    }


def _sum(drives: pd.DataFrame, told: str) -> int | None:
    """Of a column of drives, or an expression of such; None where they lack it."""
    try:
        return int(cast("pd.Series[float]", drives.eval(told)).sum())
    except pd.errors.UndefinedVariableError:
        return None
