"""Experiments from small tables, whose verdicts are known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from pipeline.driving.metrics import FAILURES
from pipeline.evaluation.drives import among, table
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, Experiment, Tables
from pipeline.evaluation.files import ErrorShares
from pipeline.metric import QUALITY
from pipeline.report.material import Material
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import CARS, COMPARISON, TRACKS, outcome

FRAMES = 1000
SPECS = COMPARISON.runs
TITLES = {name: run.name for name, run in SPECS.items()}
NOTHING = Experiment(specs=SPECS)
STRATEGIES, VARIANTS = (getattr(NOTHING, kind) for kind in ("strategies", "variants"))


@dataclass(frozen=True)
class Level:
    """How an iteration drives on average; pairs are without and with traffic."""

    laps: tuple[float, float] = (2.0, 1.5)
    """of naive"""
    safe_laps: tuple[float, float] = (3.0, 3.0)
    error: tuple[float, float] = (0.02, 0.03)
    takeover: tuple[float, float] = (0.08, 0.2)
    """of safe"""
    queries: int = 3000
    failures: int = 0
    """while it collected: touches"""
    scatter: float = 0.0
    """by this share every number is above and below in turns, over the starts"""


type Table = Mapping[str, Sequence[Level]]

FIRST = Level()
FULL = Level(laps=(3.0, 3.0), error=(0.005, 0.006), takeover=(0.02, 0.05), queries=1000)
GROWING = [
    FIRST,
    Level(laps=(2.5, 2.0), error=(0.01, 0.02), takeover=(0.05, 0.15)),
    Level(laps=(3.0, 2.8), error=(0.008, 0.01), takeover=(0.04, 0.1)),
    FULL,
]
SLOW = [
    FIRST,
    Level(laps=(2.1, 1.6), error=(0.018, 0.028), takeover=(0.075, 0.19), queries=15_000),
    Level(laps=(2.3, 1.9), error=(0.016, 0.025), takeover=(0.07, 0.18), queries=15_000),
    Level(laps=(2.4, 2.1), error=(0.015, 0.024), takeover=(0.07, 0.18), queries=5_000),
]
GOOD: Table = {
    "safedagger": GROWING,
    "dagger": SLOW,
    "dagger_budget": [replace(level, queries=FULL.queries * 3) for level in SLOW],
    "supervised": SLOW,
    "safedagger_last": GROWING,
    "safedagger_max": GROWING,
    "safedagger_rising": GROWING,
}
"""every claim of the paper holds"""


def scattered(levels: list[Level], scatter: float = 0.2) -> list[Level]:
    """The same on average."""
    return [replace(level, scatter=scatter) for level in levels]


def ending(levels: list[Level], **changes: Any) -> list[Level]:
    """The same, but for the last iteration."""
    return [*levels[:-1], replace(levels[-1], **changes)]


def experiment(table: Table, seeds: int = 1, starts: int = 4) -> Experiment:
    """Every run's iterations from 0, on all of TRACKS; the seeds are equal, each with a D_safe."""
    steps = [
        _step(seed, run, iteration, level, starts)
        for seed in range(seeds)
        for run, levels in table.items()
        for iteration, level in enumerate(levels)
    ]
    d_safe = {"queries": 5600, "frames_driven": 5600, "frames_trained": 5600, "takeover": 1.0}
    steps += [
        Tables(ledgers=pd.DataFrame([{**_at(seed, D_SAFE, 0), **d_safe, "frames_selected": 5600}]))
        for seed in range(seeds)
    ]
    return Experiment(**vars(Tables.joined(steps)), specs=SPECS)


def without(made_up: Experiment, **values: Any) -> Experiment:
    """Without the steps that have these values."""
    return made_up.keeping(lambda rows: ~rows.index.isin(among(rows, **values).index))


def undriven(made_up: Experiment, **values: Any) -> Experiment:
    """Without the drives that have these values."""
    return replace(made_up, drives=made_up.drives.drop(made_up.among(**values).index))


def redriven(made_up: Experiment, changes: Mapping[str, Any], **values: Any) -> Experiment:
    """With other columns in those of its drives that have these values; a change may be a function
    of the drives.
    """
    return replace(made_up, drives=_changed(made_up.drives, changes, **values))


def reckoned(made_up: Experiment, changes: Mapping[str, Any], **values: Any) -> Experiment:
    """The same with its ledgers."""
    return replace(made_up, ledgers=_changed(made_up.ledgers, changes, **values))


def judged(made_up: Experiment, judged_on: str, changes: Mapping[str, Any]) -> Experiment:
    """With safety policies that were judged on something so."""
    others = made_up.quality[made_up.quality.judged_on != judged_on]
    rows = made_up.quality[made_up.quality.judged_on == HELD_OUT].assign(judged_on=judged_on)
    return replace(made_up, quality=pd.concat([others, _changed(rows, changes)]))


def with_optimal(
    made_up: Experiment, runs: Sequence[str] | None = None, **changes: Any
) -> Experiment:
    """With drives like the safe ones of some runs, all by default, but for the `changes`, under the
    optimal safety policy.
    """
    safe = made_up.among(strategy=Strategy.SAFE, run=list(runs or made_up.runs))
    optimal = _changed(safe, changes).assign(strategy="optimal")
    return replace(made_up, drives=pd.concat([made_up.drives, optimal], ignore_index=True))


def material(made_up: Experiment, **changes: Any) -> Material:
    """An experiment, and each seed's errors; nothing else beside it."""
    safe = {"trained_on": {"share_safe": 0.95}, "held_out": {"share_safe": 0.8}}
    safe["held_out"]["tau_for_share"] = 0.0018
    shares = ErrorShares.model_validate({"tau": 0.0025, "share": 0.777, **safe})
    parts: dict[str, Any] = {
        "thresholds": Tables(),
        "scratch": Tables(),
        "errors": dict.fromkeys(made_up.seeds, shares),
        "curves": Experiment(specs={}),
    }
    return Material(made_up, **parts | changes)


def _changed(rows: pd.DataFrame, changes: Mapping[str, Any], **values: Any) -> pd.DataFrame:
    rows = rows.reset_index(drop=True)
    here = among(rows, **values).index
    for name, value in changes.items():
        rows[name] = rows[name].astype(float) if name in rows else 0.0
        rows.loc[here, name] = value(rows.loc[here]) if callable(value) else value
    return rows


def _at(seed: int, run: str, iteration: int) -> dict[str, Any]:
    step = f"{run}_{iteration}" if iteration else "0"
    return {"seed": seed, "run": run, "iteration": iteration, "step": step}


def _step(seed: int, run: str, iteration: int, level: Level, starts: int) -> Tables:
    at = _at(seed, run, iteration)
    drives = table(
        _drive(level, strategy, number, track, start)
        for strategy in (Strategy.NAIVE, Strategy.SAFE)
        for number in (0, 1)
        for track in TRACKS
        for start in range(starts)
    )
    ledger = {"frames_driven": FRAMES, "queries": level.queries, "frames_selected": FRAMES}
    ledger |= {"frames_trained": FRAMES, "takeover": 0.3}
    ledger |= {"calls": 60, "frames_of_calls": 300, "switches": 118, "drives": 4, "scenarios": 3}
    ledger |= {"audits": 0, "put_back": 0, "failures": level.failures}
    ledger |= {f"failures.{kind}": 0 for kind in FAILURES} | {"failures.touches": level.failures}
    nothing = {**dict.fromkeys(QUALITY, float("nan")), "calibration": []}
    return Tables(
        drives=drives.assign(**at, **{"task.laps": 3.0}),
        ledgers=pd.DataFrame([at | ledger]),
        quality=pd.DataFrame([{**at, "judged_on": HELD_OUT, "tau": 0.0025, **nothing}]),
    )


def _drive(level: Level, strategy: Strategy, number: int, track: str, start: int) -> dict[str, Any]:
    safe = strategy is Strategy.SAFE
    turn = start + safe * (1 + number)  # other starts are better for safe, and in traffic
    factor = 1 + level.scatter * (-1) ** turn
    laps = (level.safe_laps if safe else level.laps)[number] * factor
    takeover_frames = round(FRAMES * level.takeover[number] * factor) if safe else 0
    primary_frames = FRAMES - takeover_frames
    return outcome(
        scenario=track,
        traffic=float(number * CARS),
        strategy=str(strategy),
        start=start,
        laps=min(laps, 3.0),
        frames=FRAMES,
        takeover_frames=takeover_frames,
        primary_frames=primary_frames,
        deviation_sum=level.error[number] * factor * primary_frames,
        off_road=float(laps < 3.0),
    )
