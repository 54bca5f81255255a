"""What an experiment has come to: every training strategy, iteration and seed, from its metrics."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import pandas as pd

from pipeline.data.ledger import Ledger
from pipeline.evaluation.drives import among, read_drives
from pipeline.evaluation.metrics_file import MetricsFile, SafetyQuality
from pipeline.runs import BESIDE, FIRST, Comparison, Run

RUNS_FILE = "runs.json"
"""In the folder of a seed: what its runs were told, as `safedagger runs` writes it."""

_DRIVES = re.compile(r"drives_(?:(?P<run>[a-z_]+)_)?(?P<iteration>\d+)\.csv")
_SEED = re.compile(r"seed_(?P<seed>\d+)")


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration of one run on one seed."""

    seed: int
    run: str
    """one of the experiment's"""
    iteration: int
    """0 is the supervised stage, which the runs of a seed share"""
    name: str
    """of its files, `dagger_2` say: two steps of a seed with one name are the same drives"""
    drives: pd.DataFrame
    """on the test tracks, with every driving strategy: see `evaluation.drives`"""
    ledger: Ledger
    """what this iteration cost; that of D_0 in iteration 0, which is outside the loop"""
    tau: float
    """of its safety policy"""
    held_out: SafetyQuality
    """of its safety policy, on frames of D_safe, which the reference drove"""
    next_rollout: SafetyQuality | None
    """on what it met in collecting for the next iteration; None where it did not"""


@dataclass(frozen=True, eq=False)
class Experiment:
    """All steps, by (seed, run, iteration), and what the runs are."""

    steps: Mapping[tuple[int, str, int], Step]
    specs: Mapping[str, Run]
    """of each run that is compared, in the order of the report"""
    left_out: tuple[str, ...] = ()
    """a sentence for each thing that was measured and does not belong to the rest"""

    @cached_property
    def drives(self) -> pd.DataFrame:
        """Those of all steps, with "seed", "run" and "iteration", and "step", its name."""
        return all_drives(self.steps.values())

    @property
    def seeds(self) -> list[int]:
        """Every seed with any results, ascending."""
        return sorted({seed for seed, _, _ in self.steps})

    @property
    def runs(self) -> list[str]:
        """Every run that has a result."""
        present = {run for _, run, _ in self.steps}
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

    def only(self, seeds: Collection[int]) -> Self:
        """The same of these seeds alone."""
        steps = {key: step for key, step in self.steps.items() if key[0] in seeds}
        return type(self)(steps, self.specs, self.left_out)

    def of(self, run: str, iteration: int) -> list[Step]:
        """The steps of a run's iteration, one for each seed that has it, by seed."""
        keys = ((seed, run, iteration) for seed in self.seeds)
        return [self.steps[key] for key in keys if key in self.steps]

    def iterations(self, run: str) -> list[int]:
        """The iterations that a run has on any seed, ascending."""
        return sorted({iteration for _, name, iteration in self.steps if name == run})

    def among(self, **values: Any) -> pd.DataFrame:
        """The drives of which these columns have these values; of a list or tuple, one of them."""
        return among(self.drives, **values)

    def queries(self, seed: int, run: str, iteration: int) -> int:
        """Queries of the loop up to and with this iteration; D_0's and D_safe's are not of the loop."""
        return sum(
            self.steps[seed, run, number].ledger.queries for number in range(1, iteration + 1)
        )


def all_drives(steps: Iterable[Step]) -> pd.DataFrame:
    """The drives of some steps as one table, by seed, run and iteration."""
    tables = [
        step.drives.assign(seed=step.seed, run=step.run, iteration=step.iteration, step=step.name)
        for step in sorted(steps, key=lambda step: (step.seed, step.run, step.iteration))
    ]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()


def read_experiment(metrics: Path) -> Experiment:
    """Read every seed and run that `metrics` has: seed_<n>/drives_<run>_<i>.csv and its companions.

    A run's iteration 0 is the seed's own, unless the run has files of its own for it. What does not
    belong together is left out: on a seed, runs that began with another primary than SafeDAgger's;
    and on all but the first seed that has a run, what was told to do something else.

    Raises:
        ValueError: there is none, a file does not hold what it should, or there are drives of a run
            that nobody knows.
        FileNotFoundError: a companion of a file of drives is missing, or an iteration before it.
    """
    folders = {
        int(named["seed"]): folder
        for folder in sorted(metrics.glob("seed_*"))
        if (named := _SEED.fullmatch(folder.name)) and any(folder.glob("drives_*.csv"))
    }
    if not folders:
        raise ValueError(f"{metrics}: no seed_<n>/drives_<run>_<i>.csv, expected some")
    told = {seed: _told(folders[seed] / RUNS_FILE) for seed in sorted(folders)}
    specs: dict[str, Run] = {}
    for runs in told.values():
        specs = {**specs, **{name: run for name, run in runs.items() if name not in specs}}
    steps: dict[tuple[int, str, int], Step] = {}
    left_out = []
    for seed, runs in told.items():
        for run, iterations in _iterations(folders[seed], specs).items():
            if runs.get(run, specs[run]).told == specs[run].told:
                for step in _steps(folders[seed], seed, run, iterations, specs[run].is_watched):
                    steps[seed, run, step.iteration] = step
            else:
                left_out.append(
                    f"{specs[run].name}, seed {seed}: told something else than elsewhere."
                )
    found = Experiment(steps, specs, tuple(left_out))
    if not steps:
        raise ValueError(f"{metrics}: no drives of a loop, expected some of {', '.join(specs)}")
    return _belonging_together(found)


def _told(path: Path) -> dict[str, Run]:
    """What a seed's runs were told."""
    return dict(Comparison.of(MetricsFile(path).content).runs)


def _iterations(folder: Path, specs: Mapping[str, Run]) -> dict[str, list[int]]:
    """Of each run that is there: which have files of their own."""
    named = [match for file in folder.iterdir() if (match := _DRIVES.fullmatch(file.name))]
    found = {(match["run"], int(match["iteration"])) for match in named if match["run"]}
    unknown = sorted({run for run, _ in found} - {*specs, *BESIDE})
    if unknown:
        known = ", ".join(specs)
        raise ValueError(f"{folder}: drives of a run {unknown[0]!r}, expected one of {known}")
    own = {run: [i for name, i in sorted(found) if name == run] for run in specs}
    return {run: iterations for run, iterations in own.items() if any(iterations)}


def _steps(
    folder: Path, seed: int, run: str, iterations: list[int], is_watched: bool
) -> Iterator[Step]:
    """Of one run."""
    start = f"{run}_0" if 0 in iterations else FIRST
    names = [start, *(f"{run}_{i}" for i in range(1, max(iterations) + 1))]
    followers = [*names[1:], None] if is_watched else [None] * len(names)
    for iteration, (name, follower) in enumerate(zip(names, followers, strict=True)):
        yield read_step(folder, seed, run, iteration, name, follower)


def _belonging_together(found: Experiment) -> Experiment:
    """Without runs that began with another primary than SafeDAgger's of their seed."""
    left_out = list(found.left_out)
    steps = dict(found.steps)
    for seed in found.seeds:
        begun = found.among(seed=seed).groupby("run").begun_with.unique().map(set)
        ours = begun.get(found.ours, begun.iloc[0])
        for run in found.runs:
            if run in begun and begun[run] != ours:
                left_out.append(f"{found.title(run)}, seed {seed}: began with another primary.")
                steps = {key: step for key, step in steps.items() if key[:2] != (seed, run)}
    return Experiment(steps, found.specs, tuple(left_out))


def read_step(
    folder: Path, seed: int, run: str, iteration: int, name: str, follower: str | None = None
) -> Step:
    """The step whose files in `folder` are called `name`.

    Args:
        follower: the step whose rollout its policies drove; None where there is none.

    Raises:
        ValueError: a file does not hold what it should.
        FileNotFoundError: one is missing.
    """
    ledger = f"ledger_D_{name}.json" if iteration else "ledger_D_0.json"
    safety = MetricsFile(folder / f"safety_{name}.json")
    rollout = (
        MetricsFile(folder / f"rollout_{follower}.json").record(SafetyQuality, "rollout")
        if follower
        else None
    )
    return Step(
        seed=seed,
        run=run,
        iteration=iteration,
        name=name,
        drives=read_drives(folder / f"drives_{name}.csv"),
        ledger=MetricsFile(folder / ledger).record(Ledger),
        tau=safety.number("tau"),
        held_out=safety.record(SafetyQuality, "held_out"),
        next_rollout=rollout,
    )
