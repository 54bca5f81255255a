"""Experiments from small tables, whose verdicts are known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.driving.metrics import FAILURES
from pipeline.evaluation.drives import among, table
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, Experiment, Tables
from pipeline.evaluation.files import Ledger
from pipeline.metric import QUALITY
from pipeline.rollout.strategies import Strategy
from pipeline.runs import Comparison, read_params

ROOT = Path(__file__).parents[2]
COMPARISON = Comparison.of(read_params(ROOT / "scales/experiment.yaml"))
TRACKS = ("spruce", "willow", "yew")
CARS = 40
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


def outcome(**changes: Any) -> dict[str, Any]:
    """A drive that left the road half-way round the second lap."""
    values: dict[str, Any] = {
        "scenario": "yew",
        "condition": "traffic" if changes.get("traffic") else "no_traffic",
        "traffic": 0.0,
        "strategy": "naive",
        "start": 0,
        "laps": 1.5,
        "distance_m": 900.0,
        "damage": 0.0,
        "touches": 0.0,
        "frames": 500,
        "takeover_frames": 0,
        "primary_frames": 500,
        "takeovers": 0,
        "switches": 0,
        "deviation_sum": 5.0,
        "off_road": 1.0,
        "ended": "road left",
        "primary": "0" * 64,
        "begun_with": "0" * 64,
        "processor": "made up",
    }
    return values | changes


def drives(level: Level, starts: int = 4) -> pd.DataFrame:
    """By both strategies, in both conditions, on all of TRACKS."""
    return table(
        _drive(level, strategy, number, track, start)
        for strategy in (Strategy.NAIVE, Strategy.SAFE)
        for number in (0, 1)
        for track in TRACKS
        for start in range(starts)
    )


def ledger(**counted: float) -> dict[str, float]:
    """Of an iteration; nothing of what is not said, and the reference drove all of it."""
    names = (*Ledger.model_fields, *(f"failures.{kind}" for kind in FAILURES))
    return dict.fromkeys(names, 0) | {"takeover": 1.0} | counted


def experiment(table: Table, seeds: int = 1, starts: int = 4) -> Experiment:
    """Every run's iterations from 0; the seeds are equal, each with a D_safe."""
    steps = [
        _step(seed, run, iteration, level, starts)
        for seed in range(seeds)
        for run, levels in table.items()
        for iteration, level in enumerate(levels)
    ]
    d_safe = ledger(frames_driven=5600, queries=5600, frames_selected=5600, frames_trained=5600)
    steps += [
        Tables(ledgers=pd.DataFrame([_at(seed, D_SAFE, 0) | d_safe])) for seed in range(seeds)
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


def _changed(rows: pd.DataFrame, changes: Mapping[str, Any], **values: Any) -> pd.DataFrame:
    rows = rows.reset_index(drop=True)
    here = rows.index.isin(among(rows, **values).index)
    for name, value in changes.items():
        before = rows[name] if name in rows else pd.Series(0.0, rows.index)
        rows[name] = before.mask(here, value(rows) if callable(value) else value)
    return rows


def _at(seed: int, run: str, iteration: int) -> dict[str, Any]:
    step = f"{run}_{iteration}" if iteration else D_SAFE if run == D_SAFE else "0"
    return {"seed": seed, "run": run, "iteration": iteration, "step": step}


def _step(seed: int, run: str, iteration: int, level: Level, starts: int) -> Tables:
    at = _at(seed, run, iteration)
    counted = {"failures": level.failures, "failures.touches": level.failures, "takeover": 0.3}
    counted |= dict.fromkeys(("frames_driven", "frames_selected", "frames_trained"), FRAMES)
    counted |= {"calls": 60, "frames_of_calls": 300, "switches": 118, "drives": 4, "scenarios": 3}
    unknown = {**dict.fromkeys(QUALITY, float("nan")), "calibration": []}
    return Tables(
        drives=drives(level, starts).assign(**at, **{"task.laps": 3.0}),
        ledgers=pd.DataFrame([at | ledger(queries=level.queries, **counted)]),
        quality=pd.DataFrame([{**at, "judged_on": HELD_OUT, "tau": 0.0025, **unknown}]),
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
