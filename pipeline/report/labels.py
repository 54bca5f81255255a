"""How many labels each strategy needs, from the label curves: the answers, and the numbers."""

from collections.abc import Iterator
from itertools import takewhile

import pandas as pd

from pipeline.claims.labels import against
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import contrast, naive
from pipeline.evaluation.curves import ended, families, last
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import exact
from pipeline.evaluation.wording import (
    FORMS,
    NOTHING,
    count,
    interval,
    table,
    written,
)
from pipeline.metric import COLLECTED
from pipeline.report.tables import relied_on_in, successes

COST = ("failures", "calls", "call_length")
HEADER = (
    "Run",
    "Drives, seeds",
    "Labels in the loop",
    "Labels in all",
    "Success",
    "Failures per 100 km",
    "As reliable?",
    *(COLLECTED[name].title for name in COST),
)
ANSWERS = {True: "yes", False: "no", None: "undecided"}


def needed(curves: Experiment, best: str) -> Iterator[str]:
    """For each way of collecting, the fewest labels with which it is as reliable as `best`."""
    for name, family in families(curves).items():
        found = {run: against(curves, run, best).holds for run in family if run != best}
        enough = next((run for run, holds in found.items() if holds), None)
        fewer = takewhile(lambda each: not each[1], found.items())
        unknown = [curves.title(run) for run, holds in fewer if holds is None]
        still = f"; undecided: {', '.join(unknown)}" if unknown else ""
        if enough:
            spent = _spent(curves, enough, last(curves, enough))
            yield f"{name}: {count(spent.queries)} in the loop, {count(spent.labels)} in all{still}"
        elif found:
            none = "none with fewer" if best in family else "none of those measured"
            yield f"{name}: {none}{still}"


def certain(curves: Experiment) -> tuple[int, float]:
    """The most drives that a run has in a condition, and the share that surely succeed where all of them
    did: the low end of the exact 95 % interval.
    """
    drives = int(curves.drives.groupby(["run", "iteration", "condition"]).size().max())
    return drives, exact(drives, drives).low


def numbers(curves: Experiment, best: str) -> str:
    """A row for what all runs begin with, and for each run at its end."""
    unwatched = [run for run in ended(curves) if not curves.specs[run].is_watched]
    first = next(iter(unwatched or ended(curves)))  # without D_safe, if one is
    rows = [_row(curves, "before the loop", first, 0, NOTHING)]
    for family in families(curves).values():
        for run in family:
            answer = NOTHING if run == best else _answer(curves, run, best)
            rows.append(_row(curves, curves.title(run), run, last(curves, run), answer))
    return table(HEADER, rows)


def by_seed(curves: Experiment) -> str:
    """The success of each run at its end, on each seed for itself: exact."""
    rows = []
    for run in ended(curves):
        for seed in curves.seeds_of(run, last(curves, run)):
            of_seed = curves.of_seeds(seed)
            rows.append([curves.title(run), str(seed), successes(of_seed, run, last(curves, run))])
    return table(["Run", "Seed", "Success"], rows)


def _answer(curves: Experiment, run: str, best: str) -> str:
    """Whether it is as reliable, and the difference."""
    answer = ANSWERS[against(curves, run, best).holds]
    gap = contrast(curves, "success", *(naive(curves, r, last(curves, r)) for r in (run, best)))
    form = FORMS[METRICS["success"].form].difference
    return f"{answer}, {interval(gap.difference, form)}" if gap else answer


def _row(curves: Experiment, title: str, run: str, iteration: int, answer: str) -> list[str]:
    rests_on, succeeded, failed = relied_on_in(curves, run, iteration)
    spent = _spent(curves, run, iteration)
    return [
        title,
        rests_on,
        count(spent.queries),
        count(spent.labels),
        succeeded,
        failed,
        answer,
        *(written(COLLECTED[name], spent[name]) for name in COST),
    ]


def _spent(curves: Experiment, run: str, iteration: int) -> "pd.Series[float]":
    """Means over the seeds."""
    return among(curves.spent, run=run, iteration=iteration).mean(numeric_only=True)
