"""What an experiment has come to, as tables: every training strategy, iteration and seed."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import fmean
from typing import Any, Self

import pandas as pd

from pipeline.evaluation.drives import among
from pipeline.metric import FAILURE, Metric
from pipeline.runs import Run, safe_data

STEP = ["seed", "run", "iteration", "step"]
"""Columns of all tables: one iteration of one run on one seed, and what its files are called. Two
steps of a seed with one name are the same: runs share iteration 0, the supervised stage.
"""
D_SAFE = "D_safe"
"""Stands in the place of a run in the ledger of what that cost; where a run has only a part of it, the
name of that does, too.
"""
HELD_OUT, ROLLOUT = "held_out", "rollout"
"""What a safety policy was judged on: frames of D_safe, which the reference drove; what it met in
collecting for the next iteration, which it decided about.
"""

SUMMED = (
    *("queries", "frames_driven", "frames_selected", "calls", "frames_of_calls", "switches"),
    *("drives", "audits", "put_back", "failures"),
)
"""What a loop adds up of its ledgers."""
TABLES = ("drives", "ledgers", "quality")
"""The fields of `Tables`."""


def _no_steps() -> pd.DataFrame:
    return pd.DataFrame(columns=STEP)


@dataclass(frozen=True, eq=False, kw_only=True)
class Tables:
    """Some steps, each table with STEP and a row for each ..."""

    drives: pd.DataFrame = field(default_factory=_no_steps)
    """... drive on the test tracks, by every driving strategy: see `evaluation.drives`; "task.<name>"
    is what the task was set to"""
    ledgers: pd.DataFrame = field(default_factory=_no_steps)
    """... step: what this iteration cost, see `files.Ledger`; that of D_0 in iteration 0, which is
    outside the loop"""
    quality: pd.DataFrame = field(default_factory=_no_steps)
    """... thing that its safety policy was judged on ("judged_on": HELD_OUT, ROLLOUT), see
    `files.Quality`"""

    @property
    def seeds(self) -> list[int]:
        """Every seed with any drives, ascending."""
        return sorted(self.drives.seed.unique().tolist())

    @property
    def conditions(self) -> list[str]:
        """All that were driven in, in their order."""
        return self.drives.condition.unique().tolist() if len(self.drives) else []

    def most(self, metric: Metric) -> float:
        """What the metric can be at most, as the task was set; infinity where nothing says so."""
        column = f"task.{metric.most}"
        return float(self.drives[column].max()) if column in self.drives else math.inf

    def iterations(self, run: str) -> list[int]:
        """The iterations that a run has on any seed, ascending."""
        return sorted(self.drives.iteration[self.drives.run == run].unique().tolist())

    def seeds_of(self, run: str, iteration: int) -> list[int]:
        """The seeds that have a run's iteration, ascending."""
        return sorted(self.among(run=run, iteration=iteration).seed.unique().tolist())

    def among(self, **values: Any) -> pd.DataFrame:
        """The drives of which these columns have these values; of a list or tuple, one of them."""
        return among(self.drives, **values)

    def keeping(self, keep: Callable[[pd.DataFrame], "pd.Series[bool]"]) -> Self:
        """The same with those rows alone that `keep` says of a table, by its STEP."""
        tables = {name: getattr(self, name) for name in TABLES}
        return replace(self, **{name: table[keep(table)] for name, table in tables.items()})

    def of_seeds(self, *seeds: int) -> Self:
        """The same with these seeds alone."""
        return self.keeping(lambda rows: rows.seed.isin(seeds))

    @staticmethod
    def joined(parts: Iterable["Tables"]) -> "Tables":
        """All rows of all parts, by seed, run and iteration."""
        found = list(parts)
        return Tables(**{name: _sorted(getattr(part, name) for part in found) for name in TABLES})


@dataclass(frozen=True, eq=False, kw_only=True)
class Experiment(Tables):
    """All steps, and what the runs are."""

    specs: Mapping[str, Run]
    """of each run that is compared, in the order of the report"""
    left_out: tuple[str, ...] = ()
    """a sentence for each thing that was measured and does not belong to the rest"""

    @property
    def runs(self) -> list[str]:
        """Every run that has a result."""
        present = set(self.drives.run)
        return [run for run in self.specs if run in present]

    @property
    def ours(self) -> str | None:
        """SafeDAgger itself, which the others are compared with; None where there is no such run."""
        watched = (name for name, run in self.specs.items() if run.is_watched)
        return next((name for name in watched if self.specs[name].variant_of is None), None)

    @property
    def strategies(self) -> list[str]:
        """The training strategies: all runs that are no variants."""
        return [name for name, run in self.specs.items() if run.variant_of is None]

    @property
    def variants(self) -> list[str]:
        """SafeDAgger and the variants of it."""
        return [n for n, run in self.specs.items() if self.ours in (n, run.variant_of)]

    @property
    def last(self) -> int:
        """The last iteration of the longest loop."""
        return max((len(run.iterations) for run in self.specs.values()), default=0)

    def title(self, run: str) -> str:
        """Its name in the report."""
        return self.specs[run].name

    @cached_property
    def spent(self) -> pd.DataFrame:
        """What each step has cost so far: the ledgers, with what they count summed over the loop,
        which D_0 is outside of, but for the frames trained on and the scenarios, which are those of
        the iteration with the most, as all go around the same; "takeover" as the share of the frames
        driven; "call_length", frames of a call; and "labels", queries in all: D_0's, the loop's and,
        where the loop needs a dataset for its safety policy, D_safe's. Of other runs the safety
        policies exist only to measure. NaN from where a ledger lacks the number.
        """
        rows = self.ledgers.sort_values(STEP[:3], ignore_index=True)
        before = rows[rows.iteration == 0].set_index(["seed", "run"]).queries
        kinds = rows.filter(like=FAILURE).columns
        counted = rows[[*SUMMED, *kinds]].assign(by_reference=rows.takeover * rows.frames_driven)
        so_far = _loops(rows, counted).cumsum(skipna=False)
        first = pd.MultiIndex.from_frame(rows[["seed", "run"]])
        needing = {n: f"D_{safe_data(n, run)}" for n, run in self.specs.items() if run.needs_d_safe}
        of_safe = pd.MultiIndex.from_arrays([rows.seed, rows.run.map(needing)])
        return rows.assign(
            **so_far[[*SUMMED, *kinds]],
            scenarios=_loops(rows, rows[["scenarios"]]).cummax(skipna=False),
            takeover=so_far.by_reference / so_far.frames_driven,
            call_length=so_far.frames_of_calls / so_far.calls,
            labels=before.reindex(first).to_numpy()
            + so_far.queries
            + before.reindex(of_safe).where(rows.run.isin(needing).to_numpy(), 0).to_numpy(),
        )


def mean(table: pd.DataFrame, metric: Metric, **values: Any) -> float | None:
    """Of the rows of a table whose columns have these values; None where it is known of none."""
    known = among(table, **values)[metric.part].dropna() if len(table) else ()
    return fmean(known) if len(known) else None


def _loops(rows: pd.DataFrame, counted: pd.DataFrame) -> Any:
    """What is counted in `rows`, by seed and run, without what is outside the loop."""
    return counted.where(rows.iteration > 0, 0).groupby([rows.seed, rows.run])


def _sorted(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    filled = [table for table in tables if len(table)]
    if not filled:
        return _no_steps()
    joined = pd.concat(filled, ignore_index=True)
    return joined.sort_values(STEP[:3], kind="stable", ignore_index=True)
