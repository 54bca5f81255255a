"""Where a run does less than three laps without damage, and how the drives ended there."""

from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import Step
from pipeline.evaluation.summary import LAPS, Performance, measure
from pipeline.evaluation.wording import CONDITION_WORDS, amount, laps, table
from pipeline.report.endings import left_the_road, stopped_short


@dataclass(frozen=True)
class Shortfall:
    """A seed, strategy, condition and track where laps are missing or there is damage."""

    seed: int
    strategy: str
    condition: str
    track: str
    performance: Performance
    left: int
    """drives that left the road"""
    stopped: int
    """drives that stopped short on it"""
    hit: int
    """drives with damage"""


def falls_short(steps: list[Step]) -> str:
    """The shortfalls of one step on each seed, in words and as a table."""
    cases = [case for step in steps for case in _cases(step)]
    found = [case for case in cases if (case.performance["laps"] or 0) < LAPS or case.hit]
    where = f"In the drives after iteration {steps[0].iteration}"
    if not found:
        return (
            f"{where}: in no case. There are {LAPS:g} laps without damage in each of {len(cases)} "
            "cases of seed, driving strategy, traffic and track."
        )
    rows = [
        [
            str(case.seed),
            f"{case.strategy}, {CONDITION_WORDS[case.condition]}, {case.track}",
            laps(case.performance["laps"]),
            amount(case.performance["damage_per_lap"]),
            *(f"{n} of {case.performance['drives']}" for n in (case.left, case.stopped, case.hit)),
        ]
        for case in found
    ]
    header = ["Seed", "Case", "Laps", "Damage per lap", "Left the road", "Stopped short", "Hit"]
    left, stopped = sum(case.left for case in found), sum(case.stopped for case in found)
    hit = sum(case.hit for case in found)
    return (
        f"{where}: in {len(found)} of {len(cases)} cases of seed, driving strategy, traffic and "
        f"track, with less than {LAPS:g} laps or some damage. Of the drives there, {left} ended by leaving "
        f"the road, {stopped} stopped short on it (stood still, or ran out of time), and {hit} hit "
        f"another car.\n\n{table(header, rows, words=2)}"
    )


def _cases(step: Step) -> Iterator[Shortfall]:
    """Each strategy, condition and track that was driven, in this order."""
    for case, drives in step.drives.groupby(["strategy", "condition", "scenario"]):
        strategy, where, track = map(str, case)
        yield Shortfall(
            step.seed,
            strategy,
            where,
            track,
            measure(drives, METRICS),
            left=int(left_the_road(drives).sum()),
            stopped=int(stopped_short(drives).sum()),
            hit=int((drives.damage > 0).sum()),
        )
