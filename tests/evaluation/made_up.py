"""Experiments from small tables, whose verdicts are known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from pipeline.data.ledger import Ledger
from pipeline.evaluation.drives import among, table
from pipeline.evaluation.experiment import Experiment, Step
from pipeline.evaluation.metrics_file import SafetyQuality
from pipeline.report.material import ErrorShares, Material
from pipeline.rollout.strategies import Strategy
from tests.evaluation.sample import CARS, COMPARISON, TRACKS, outcome

FRAMES = 1000
SPECS = COMPARISON.runs
TITLES = {name: run.name for name, run in SPECS.items()}
STRATEGIES, VARIANTS = (getattr(Experiment({}, SPECS), kind) for kind in ("strategies", "variants"))


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
    """Every run's iterations from 0, on all of TRACKS; the seeds are equal."""
    return of_steps(
        {
            (seed, run, iteration): _step(seed, run, iteration, level, starts)
            for seed in range(seeds)
            for run, levels in table.items()
            for iteration, level in enumerate(levels)
        }
    )


def of_steps(steps: Mapping[tuple[int, str, int], Step]) -> Experiment:
    """With the runs of the comparison at the default scale."""
    return Experiment(steps, SPECS)


def changed(made_up: Experiment, change: Callable[[Step], Step]) -> Experiment:
    """The same, but for what `change` makes of each step."""
    return of_steps({key: change(step) for key, step in made_up.steps.items()})


def with_optimal(step: Step, **changes: Any) -> Step:
    """With drives like the safe ones, but for the `changes`, under the optimal safety policy."""
    optimal = among(step.drives, strategy=Strategy.SAFE).assign(strategy="optimal", **changes)
    return replace(step, drives=pd.concat([step.drives, optimal], ignore_index=True))


def only(step: Step, **values: Any) -> Step:
    """With those of its drives that have these values."""
    return replace(step, drives=among(step.drives, **values))


def redriven(step: Step, changes: Mapping[str, Any], **values: Any) -> Step:
    """With other columns in those of its drives that have these values; a change may be a function
    of the drives."""
    drives = step.drives.copy()
    rows = among(drives, **values).index
    for name, value in changes.items():
        drives[name] = drives[name].astype(float) if name in drives else 0.0
        drives.loc[rows, name] = value(drives.loc[rows]) if callable(value) else value
    return replace(step, drives=drives)


def material(made_up: Experiment, **changes: Any) -> Material:
    """An experiment, and each seed's D_safe and errors; nothing else beside it."""
    parts: dict[str, Any] = {
        "thresholds": {},
        "scratch": of_steps({}),
        "d_safe": {seed: Ledger(5600, 5600, 5600, 5600, 1.0) for seed in made_up.seeds},
        "errors": {
            seed: ErrorShares(0.0025, 0.95, 0.8, share=0.777, tau_for_share=0.0018)
            for seed in made_up.seeds
        },
    }
    return Material(made_up, **parts | changes)


def _step(seed: int, run: str, iteration: int, level: Level, starts: int) -> Step:
    return Step(
        seed=seed,
        run=run,
        iteration=iteration,
        name=f"{run}_{iteration}" if iteration else "0",
        drives=table(
            _drive(level, strategy, number, track, start)
            for strategy in (Strategy.NAIVE, Strategy.SAFE)
            for number in (0, 1)
            for track in TRACKS
            for start in range(starts)
        ),
        ledger=Ledger(FRAMES, level.queries, FRAMES, FRAMES, 0.3),
        tau=0.0025,
        held_out=SafetyQuality(None, None, None, None, None),
        next_rollout=None,
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
