"""Where a run does less than all laps without damage, and how the drives ended there."""

import pandas as pd

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import measure
from pipeline.evaluation.wording import in_condition, table, written
from pipeline.metric import shown
from pipeline.report.tables import left_the_road, most_laps, stopped_short

HEADER = ["Seed", "Case", "Laps", "Damage per lap", "Left the road", "Stopped short", "Hit"]


def falls_short(experiment: Experiment, run: str) -> str:
    """The shortfalls after a run's last iteration on each seed, in words and as a table: seeds,
    strategies, conditions and tracks where laps are missing or there is damage.
    """
    last = experiment.iterations(run)[-1]
    drives = experiment.among(run=run, iteration=last)
    drives = drives.assign(
        left=left_the_road(drives), stopped=stopped_short(drives), hit=drives.damage > 0
    )
    cases = list(drives.groupby(["seed", "strategy", "condition", "scenario"]))
    found = [(case, group) for case, group in cases if _is_short(group)]
    where = f"In the drives after iteration {last}"
    laps = most_laps(experiment)
    if not found:
        return (
            f"{where}: in no case. There are {laps} laps without damage in each of {len(cases)} "
            "cases of seed, driving strategy, traffic and track."
        )
    rows = [_row(list(map(str, case)), group) for case, group in found]
    left, stopped, hit = pd.concat([group for _, group in found])[["left", "stopped", "hit"]].sum()
    return (
        f"{where}: in {len(found)} of {len(cases)} cases of seed, driving strategy, traffic and "
        f"track, with less than {laps} laps or some damage. Of the drives there, {left} ended by leaving "
        f"the road, {stopped} stopped short on it (stood still, or ran out of time), and {hit} hit "
        f"another car.\n\n{table(HEADER, rows, words=2)}"
    )


def _is_short(drives: pd.DataFrame) -> bool:
    """Whether the mean laps are less than all, or somebody hit a car."""
    laps = measure(drives, {"laps": METRICS["laps"]})["laps"] or 0
    return bool(laps < drives["task.laps"].max() or drives.hit.any())


def _row(case: list[str], drives: pd.DataFrame) -> list[str]:
    seed, strategy, where, track = case
    found = measure(drives, shown(METRICS, "tables"))
    return [
        seed,
        f"{strategy}, {in_condition(where)}, {track}",
        *(written(METRICS[name], found[name]) for name in ("laps", "damage_per_lap")),
        *(f"{drives[name].sum()} of {len(drives)}" for name in ("left", "stopped", "hit")),
    ]
