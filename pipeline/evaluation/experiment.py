"""What an experiment has come to: every training strategy, iteration and seed, from its metrics."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.ledger import Ledger
from pipeline.evaluation.drives import among, read_drives
from pipeline.evaluation.metrics_file import MetricsFile, SafetyQuality

RUNS = {
    "supervised": "supervised",
    "dagger": "DAgger",
    "dagger_budget": "DAgger, SafeDAgger's queries",
    "safedagger": "SafeDAgger",
    "safedagger_last": "SafeDAgger, 1 s ahead (last)",
    "safedagger_max": "SafeDAgger, 1 s ahead (max)",
    "safedagger_rising": "SafeDAgger, rising tau",
}
"""The branches of the experiment, in the order of the report, and their names there."""
TRAINING = ("safedagger", "dagger", "dagger_budget", "supervised")
"""The training strategies that are compared."""
VARIANTS = ("safedagger", "safedagger_last", "safedagger_max", "safedagger_rising")
"""SafeDAgger and its variants: the runs whose safety policies decide in rollouts."""

_DRIVES = re.compile(r"drives_(?:(?P<run>[a-z_]+)_)?(?P<iteration>\d+)\.csv")
_SEED = re.compile(r"seed_(?P<seed>\d+)")


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration of one run on one seed."""

    seed: int
    run: str
    """one of RUNS"""
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
    """All steps, by (seed, run, iteration)."""

    steps: Mapping[tuple[int, str, int], Step]

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
        """Every run that has a result, in the order of RUNS."""
        present = {run for _, run, _ in self.steps}
        return [run for run in RUNS if run in present]

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

    A run's iteration 0 is the seed's own, unless the run has files of its own for it.

    Raises:
        ValueError: there is none, or a file does not hold what it should.
        FileNotFoundError: a companion of a file of drives is missing, or an iteration before it.
    """
    steps = {}
    for folder in sorted(metrics.glob("seed_*")):
        named = _SEED.fullmatch(folder.name)
        if named:
            for step in _steps(folder, int(named["seed"])):
                steps[step.seed, step.run, step.iteration] = step
    if not steps:
        raise ValueError(f"{metrics}: no seed_<n>/drives_<run>_<i>.csv, expected some")
    return Experiment(steps)


def _steps(folder: Path, seed: int) -> Iterator[Step]:
    named = [match for file in folder.iterdir() if (match := _DRIVES.fullmatch(file.name))]
    found = {(match["run"], int(match["iteration"])) for match in named if match["run"] in RUNS}
    for run in sorted({run for run, iteration in found if iteration > 0}):
        last = max(iteration for other, iteration in found if other == run)
        start = f"{run}_0" if (run, 0) in found else "0"
        names = [start, *(f"{run}_{iteration}" for iteration in range(1, last + 1))]
        followers = [*names[1:], None] if run in VARIANTS else [None] * len(names)
        for iteration, (name, follower) in enumerate(zip(names, followers, strict=True)):
            yield read_step(folder, seed, run, iteration, name, follower)


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
