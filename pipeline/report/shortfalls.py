"""Where a run falls short: its drives, and what SafeDAgger is short of however these went, beside what is
ideal, and beside DAgger.
"""

from collections.abc import Iterator

import pandas as pd

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import ROLLOUT, Experiment, mean
from pipeline.evaluation.summary import measure
from pipeline.evaluation.wording import NOTHING, in_condition, table, written
from pipeline.metric import QUALITY, shown
from pipeline.report.tables import (
    NAIVE,
    OPTIMAL,
    SAFE,
    estimates,
    left_the_road,
    most_laps,
    stopped_short,
)
from pipeline.rollout.strategies import Strategy

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


def limits(experiment: Experiment, ours: str) -> str:
    """A point for each thing that was measured; empty where there is none."""
    last = experiment.iterations(ours)[-1]
    points = [
        *_unsafe_frames(experiment, ours),
        *_takeover(experiment, ours, last),
        *_steering(experiment, ours, last),
    ]
    return "\n".join(f"- {point}" for point in points)


def _unsafe_frames(experiment: Experiment, ours: str) -> Iterator[str]:
    """How many the safety policies found, in the rollouts that they decided about."""
    recall, auroc = (_range(experiment, ours, name) for name in ("recall", "auroc"))
    if recall and auroc:
        yield (
            "In the rollouts that they decided about, its safety policies called unsafe "
            f"{recall} of the truly unsafe frames (recall), with an AUROC of {auroc} (1 is perfect, "
            "0.5 is chance): means over the seeds, lowest and highest of the iterations."
        )


def _takeover(experiment: Experiment, ours: str, last: int) -> Iterator[str]:
    learned, optimal = (
        _pair(experiment, "takeover", ours, last, strategy) for strategy in (SAFE, OPTIMAL)
    )
    if learned and optimal:
        yield (
            f"After iteration {last}, the reference drives {learned} of the time (without and with "
            f"traffic) under its learned safety policies, and {optimal} under the optimal one (Eq. 2), "
            "where it drives whenever the primary truly deviates."
        )


def _steering(experiment: Experiment, ours: str, last: int) -> Iterator[str]:
    """Beside the first DAgger that there is."""
    rivals = [run for run in experiment.runs if experiment.specs[run].strategy == "dagger"]
    for rival in rivals[:1]:
        mine, theirs = (
            _pair(experiment, "steering_mse", run, last, NAIVE) for run in (ours, rival)
        )
        if mine and theirs:
            yield (
                f"After iteration {last}, the steering MSE of its primary, driven naively, is {mine} "
                f"(without and with traffic), and {theirs} in {experiment.title(rival)}."
            )


def _range(experiment: Experiment, ours: str, name: str) -> str:
    """Of one of QUALITY in the rollouts, over the iterations; empty where it is not known."""
    metric = QUALITY[name]
    means = [
        mean(experiment.quality, metric, run=ours, iteration=iteration, judged_on=ROLLOUT)
        for iteration in experiment.iterations(ours)
    ]
    known = [value for value in means if value is not None]
    ends = [written(metric, end(known)) for end in (min, max)] if known else []
    return " to ".join(dict.fromkeys(ends))


def _pair(experiment: Experiment, metric: str, run: str, iteration: int, strategy: Strategy) -> str:
    """In each condition; empty where one is not known."""
    found = estimates(experiment, metric, run, iteration, strategy)
    return "" if NOTHING in found else " and ".join(found)
