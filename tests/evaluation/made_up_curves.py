"""Label curves from small tables, whose verdicts are known."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from pipeline.evaluation.drives import table, write_drives
from pipeline.evaluation.experiment import D_SAFE, Experiment, Tables
from pipeline.evaluation.writing import write_metrics
from pipeline.output import write_file
from pipeline.runs import Comparison, read_params, safe_data
from tests.evaluation.made_up import CARS, ROOT, ledger, outcome

SPECS = Comparison.of(read_params(ROOT / "scales/curves.yaml")).runs
D_0, SAFE_LABELS = 2800, 5600
LAPS = [{"condition": where, "name": "car", "laps": 1.0} for where in ("no_traffic", "traffic")]
BEFORE = 0.5
"""the share of the drives that succeed before the loop"""


def curves(successes: Mapping[str, float], seeds: int = 1, tracks: int = 40) -> Experiment:
    """Runs before and after their loops, by the share of the tracks on which each succeeds in the end,
    the first of them, in both conditions; the seeds are equal.
    """
    parts = [
        part
        for seed in range(seeds)
        for run, share in successes.items()
        for part in (_step(seed, run, 0, BEFORE, tracks), *_loop(seed, run, share, tracks))
    ]
    own = {
        f"D_{safe_data(run, SPECS[run])}": SPECS[run].d_safe
        for run in successes
        if SPECS[run].has_own_d_safe
    }
    d_safe = [
        _ledger(seed, name, 0, round(share * SAFE_LABELS))
        for seed in range(seeds)
        for name, share in ({D_SAFE: 1.0} | own).items()
    ]
    return Experiment(**vars(Tables.joined([*parts, *d_safe])), specs=SPECS)


def drives(share: float, tracks: int = 40) -> pd.DataFrame:
    """A lap of each track, without and with traffic: a lap done, or half of one."""
    return table(
        outcome(
            scenario=f"random:{1000 + number}",
            traffic=float(traffic),
            laps=1.0 if number < share * tracks else 0.5,
            distance_m=1000.0,
            off_road=float(number >= share * tracks),
            ended="laps done" if number < share * tracks else "road left",
        )
        for traffic in (0, CARS)
        for number in range(tracks)
    )


def counted(queries: int) -> dict[str, float]:
    """A ledger in which the reference drove each frame that it was asked in, in ten calls."""
    return ledger(
        frames_driven=2 * queries,
        queries=queries,
        frames_selected=queries,
        frames_trained=D_0 + queries,
        takeover=0.5,
        calls=10,
        frames_of_calls=queries,
        failures=1,
    )


def write_seed(folder: Path, *steps: str, ledgers: bool = True, kind: str = "reliability") -> Path:
    """What `scales/run` leaves of a seed whose primaries of some steps were driven."""
    told = Comparison(runs=dict(SPECS), protocols={"line": {}, "briefly": {}, "anywhere": {}})
    write_file(folder / "runs.json", told.model_dump_json(exclude_defaults=True).encode())
    for step in steps:
        write_drives(folder / f"{kind}_{step}.csv", drives(0.5, tracks=2))
        write_metrics(folder / f"{kind}_{step}.json", {"rows": LAPS})
    for step in ("safe", *(each for each in steps if "training" not in each)) if ledgers else ():
        write_metrics(folder / f"ledger_D_{step}.json", {"rows": [counted(100)]})
    return folder


def _loop(seed: int, run: str, share: float, tracks: int) -> list[Tables]:
    spec = SPECS[run]
    asked = spec.queries or spec.frames or [40 * each for each in spec.episodes] or [0, 0, 0]
    return [
        *(_ledger(seed, run, i, queries) for i, queries in enumerate(asked[:-1], 1)),
        _step(seed, run, len(asked), share, tracks, asked[-1]),
    ]


def _step(
    seed: int, run: str, iteration: int, share: float, tracks: int, queries: int = D_0
) -> Tables:
    at = {"seed": seed, "run": run, "iteration": iteration, "step": f"{run}_{iteration}"}
    driven = drives(share, tracks).assign(**at, **{"task.laps": 1.0})
    return Tables(drives=driven, ledgers=_ledger(seed, run, iteration, queries).ledgers)


def _ledger(seed: int, run: str, iteration: int, queries: int) -> Tables:
    at = {"seed": seed, "run": run, "iteration": iteration, "step": f"{run}_{iteration}"}
    return Tables(ledgers=pd.DataFrame([at | counted(queries)]))
