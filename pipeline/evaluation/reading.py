"""Reading what the commands have measured of every seed and run: tables."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import BaseModel

from pipeline.evaluation.drives import read_drives
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, ROLLOUT, STEP, Experiment, Tables
from pipeline.evaluation.files import ErrorShares, Ledger, Quality, Rows, Setting, read_json
from pipeline.runs import BESIDE, FIRST, Comparison, Run, safe_data

RUNS_FILE = "runs.json"
"""In the folder of a seed: what its runs were told, as `safedagger runs` writes it."""
WARM, SCRATCH = "warm", "scratch"
"""Runs of `read_scratch`."""

type Steps = Callable[[Path, int, str, list[int], Run], Iterator[Tables]]
"""Reads those of a run, from the folder of a seed"""

_DRIVES, _RELIABILITY, _CROWD = "drives", "reliability", "crowd"
_STEP = re.compile(r"_(?:(?P<run>[a-z]\w*)_)?(?P<number>\d+)\.csv")
_SEED = re.compile(r"seed_(?P<seed>\d+)")


def read_experiment(metrics: Path) -> Experiment:
    """Read every seed and run that `metrics` has: seed_<n>/drives_<run>_<i>.csv and its companions.

    A run's iteration 0 is the seed's own, unless the run has files of its own for it. What does not
    belong together is left out: on a seed, runs that began with another primary than SafeDAgger's;
    and on all but the first seed that has a run, what was told to do something else.

    ValueError where there is none, a file does not hold what it should, or there are drives of a run that
    nobody knows; FileNotFoundError where a companion of a file of drives, or an iteration before it, is
    missing.
    """
    if not _seeds(metrics):
        raise ValueError(f"{metrics}: no seed_<n>/drives_<run>_<i>.csv, expected some")
    found = _read(metrics, _DRIVES, _steps, _ledger)
    if found.drives.empty:
        known = ", ".join(found.specs)
        raise ValueError(f"{metrics}: no drives of a loop, expected some of {known}")
    return found


def read_reliability(metrics: Path) -> Experiment:
    """Read how reliable the primaries are, and what they cost: seed_<n>/reliability_<run>_<i>.csv, ...

    Drives are naive. Of a seed that is only partly done there is what is there; what its ledgers do
    not tell is NaN. Empty where there are none. Left out is the same as in `read_experiment`. ValueError
    where a file does not hold what it should, or there are drives of a run that nobody knows.
    """
    return _read(metrics, _RELIABILITY, partial(_relied_on, _RELIABILITY), _ledger_if_any)


def read_crowd(metrics: Path) -> Experiment:
    """Read the same of the primaries in a crowd: seed_<n>/crowd_<run>_<i>.csv, ..."""
    return _read(metrics, _CROWD, partial(_relied_on, _CROWD), _ledger_if_any)


def read_thresholds(metrics: Path) -> Tables:
    """The supervised primary with safety policies of several tau, each a run that is called as it.

    Reads seed_<n>/drives_tau_<digits>.csv and its companions, and iteration 0's own beside them.
    Empty where there are none. ValueError where a file does not hold what it should, or two of a seed
    have the same tau; FileNotFoundError where a companion of a file of drives is missing.
    """
    parts = []
    for seed, folder in _seeds(metrics).items():
        varied = [name for name, run, _ in _names(folder) if run == "tau"]
        steps = {
            name: _read_step(folder, seed, "", 0, name)
            for name in ([FIRST, *varied] if varied else [])
        }
        found = set()
        for name, step in steps.items():
            if {*step.drives.primary} != {*steps[FIRST].drives.primary}:
                continue  # it watched another primary, of an earlier run
            tau = f"{step.quality.tau.iloc[0]:g}"
            if tau in found:
                file = folder / f"drives_{name}.csv"
                raise ValueError(f"{file}: tau is {tau} again, expected another")
            found.add(tau)
            named = {table: rows.assign(run=tau) for table, rows in vars(step).items()}
            parts.append(Tables(**named))
    return Tables.joined(parts)


def read_scratch(metrics: Path, experiment: Experiment) -> Tables:
    """The drives of two runs, WARM and SCRATCH: the iterations that a seed has both ways.

    Reads seed_<n>/drives_scratch_<i>.csv. Without a warm counterpart, that began with the same
    primary, there is nothing to compare it with. ValueError where a file does not hold what it should.
    """
    parts = []
    both_ways = [run for run, spec in experiment.specs.items() if spec.from_scratch]
    for seed, folder in _seeds(metrics).items():
        for name, run, iteration in _names(folder):
            warm = experiment.among(seed=seed, run=both_ways, iteration=iteration)
            if run == SCRATCH and len(warm):
                scratch = read_driven(folder, name).assign(**_at(seed, SCRATCH, iteration, name))
                if set(warm.begun_with) == set(scratch.begun_with):
                    parts += [Tables(drives=warm.assign(run=WARM)), Tables(drives=scratch)]
    return Tables.joined(parts)


def read_errors(metrics: Path) -> dict[int, ErrorShares]:
    """By seed; one may have none. ValueError where a file does not hold what it should."""
    files = {seed: folder / "errors.json" for seed, folder in _seeds(metrics).items()}
    return {seed: read_json(file, ErrorShares) for seed, file in files.items() if file.is_file()}


def _read(
    metrics: Path, kind: str, steps: Steps, ledger: Callable[..., pd.DataFrame]
) -> Experiment:
    """All seeds and runs that have drives of a kind."""
    folders = _seeds(metrics, kind)
    told = {
        seed: dict(Comparison.of(read_json(folder / RUNS_FILE, dict)).runs)
        for seed, folder in folders.items()
    }
    specs: dict[str, Run] = {}
    for runs in told.values():
        specs = {**specs, **{name: run for name, run in runs.items() if name not in specs}}
    parts: list[Tables] = []
    left_out = []
    for seed, runs in told.items():
        datasets = [D_SAFE]
        for run, iterations in _iterations(folders[seed], kind, specs).items():
            if runs.get(run, specs[run]).told == specs[run].told:
                parts += steps(folders[seed], seed, run, iterations, specs[run])
                if specs[run].has_own_d_safe:
                    datasets.append(f"D_{safe_data(run, specs[run])}")
            else:
                left_out.append(
                    f"{specs[run].name}, seed {seed}: told something else than elsewhere."
                )
        for dataset in datasets:
            at = _at(seed, dataset, 0, dataset)
            parts.append(Tables(ledgers=ledger(folders[seed] / f"ledger_{dataset}.json", **at)))
    found = Experiment(**vars(Tables.joined(parts)), specs=specs, left_out=tuple(left_out))
    return _belonging_together(found)


def _seeds(metrics: Path, kind: str = _DRIVES) -> dict[int, Path]:
    """The folders of all seeds that have drives of a kind, ascending."""
    found = {
        int(named["seed"]): folder
        for folder in metrics.glob("seed_*")
        if (named := _SEED.fullmatch(folder.name)) and any(folder.glob(f"{kind}_*.csv"))
    }
    return dict(sorted(found.items()))


def _names(folder: Path, kind: str = _DRIVES) -> list[tuple[str, str | None, int]]:
    """Of all drives of a seed: name of the step, of its run if it has one, and the number in it."""
    return [
        (file.stem.removeprefix(f"{kind}_"), named["run"], int(named["number"]))
        for file in sorted(folder.glob(f"{kind}_*.csv"))
        if (named := _STEP.fullmatch(file.name.removeprefix(kind)))
    ]


def _iterations(folder: Path, kind: str, specs: Mapping[str, Run]) -> dict[str, list[int]]:
    """Of each run that is there: which have files of their own."""
    found = sorted((run, number) for _, run, number in _names(folder, kind) if run)
    unknown = [run for run, _ in found if run not in (*specs, *BESIDE)]
    if unknown:
        known = ", ".join(specs)
        raise ValueError(f"{folder}: drives of a run {unknown[0]!r}, expected one of {known}")
    own = {run: [number for name, number in found if name == run] for run in specs}
    return {run: iterations for run, iterations in own.items() if any(iterations)}


def _steps(folder: Path, seed: int, run: str, iterations: list[int], spec: Run) -> Iterator[Tables]:
    """Of one run of the loops."""
    start = f"{run}_0" if 0 in iterations else FIRST
    names = [start, *(f"{run}_{i}" for i in range(1, max(iterations) + 1))]
    followers = [*names[1:], None] if spec.is_watched else [None] * len(names)
    for iteration, (name, follower) in enumerate(zip(names, followers, strict=True)):
        yield _read_step(folder, seed, run, iteration, name, follower)


def _relied_on(
    kind: str, folder: Path, seed: int, run: str, iterations: list[int], spec: Run
) -> Iterator[Tables]:
    """Of one run; where nothing is collected, nothing is asked."""
    for iteration in range(max(iterations) + 1):
        name = f"{run}_{iteration}" if iteration or 0 in iterations else FIRST
        at = _at(seed, run, iteration, name)
        cost = _ledger_if_any(folder / f"ledger_D_{name if iteration else FIRST}.json", **at)
        if iteration and not spec.collects:
            cost = pd.DataFrame([dict.fromkeys(Ledger.model_fields, 0) | at])
        driven = (
            read_driven(folder, name, kind, kind).assign(**at)
            if iteration in (0, *iterations)
            else pd.DataFrame()
        )
        yield Tables(drives=driven, ledgers=cost)


def _belonging_together(found: Experiment) -> Experiment:
    """Without runs that began with another primary than SafeDAgger's of their seed, but for those that
    were told to, by setting something of D_0 aside.
    """
    shared = [run for run in found.runs if not found.specs[run].set_aside]
    for seed in found.seeds:
        drives = found.among(seed=seed, run=shared)
        begun = drives.groupby("run").begun_with.unique().map(set)
        ours = begun.get(found.ours, next(iter(begun), None))
        for run in [run for run in shared if begun.get(run, ours) != ours]:
            told = f"{found.title(run)}, seed {seed}: began with another primary."
            kept = found.keeping(partial(_is_not, seed, run))
            found = replace(kept, left_out=(*found.left_out, told))
    return found


def _is_not(seed: int, run: str, rows: pd.DataFrame) -> "pd.Series[bool]":
    return (rows.seed != seed) | (rows.run != run)


def _read_step(
    folder: Path, seed: int, run: str, iteration: int, name: str, follower: str | None = None
) -> Tables:
    """The step whose files in `folder` are called `name`; its policies drove the rollout of the follower,
    if there is one.
    """
    at = _at(seed, run, iteration, name)
    judged = [_rows(folder / f"safety_{name}.json", Quality, **at, judged_on=HELD_OUT)]
    if follower:
        rollout = folder / f"rollout_{follower}.json"
        judged.append(_rows(rollout, Quality, **at, judged_on=ROLLOUT))
    return Tables(
        drives=read_driven(folder, name).assign(**at),
        ledgers=_ledger(folder / f"ledger_D_{name if iteration else FIRST}.json", **at),
        quality=pd.concat(judged, ignore_index=True),
    )


def read_driven(
    folder: Path, name: str, drives: str = _DRIVES, settings: str = "driving"
) -> pd.DataFrame:
    """The drives of a step, each with what its condition's task was set to, from files that begin with
    `drives` and `settings`. Raises as `read_drives` and `read_json`.
    """
    driven = read_drives(folder / f"{drives}_{name}.csv")
    file = folder / f"{settings}_{name}.json"
    rows = _rows(file, Setting).fillna({"laps": math.inf})
    for condition in driven.condition.unique():
        if condition not in set(rows.condition):
            raise ValueError(f"{file}: no row of condition {condition!r}, expected one")
    told = rows.set_index("condition").add_prefix("task.").loc[driven.condition]
    return pd.concat([driven, told.set_index(driven.index)], axis=1)


def _at(*step: Any) -> dict[str, Any]:
    """The columns of a step, which all tables have."""
    return dict(zip(STEP, step, strict=True))


def _ledger(file: Path, **at: Any) -> pd.DataFrame:
    return _rows(file, Ledger, **at)


def _ledger_if_any(file: Path, **at: Any) -> pd.DataFrame:
    """Of NaN where there is none."""
    unknown = dict.fromkeys(Ledger.model_fields, math.nan)
    return _ledger(file, **at) if file.is_file() else pd.DataFrame([unknown | at])


def _rows(file: Path, kind: type[BaseModel], **columns: Any) -> pd.DataFrame:
    """Those of a file, and columns that are the same in all; NaN for null."""
    read: Rows[BaseModel] = read_json(file, Rows[kind])  # type: ignore[valid-type]
    rows = [row.model_dump() for row in read.rows]
    known = [{k: math.nan if v is None else v for k, v in row.items()} for row in rows]
    return pd.DataFrame(known).assign(**columns)
