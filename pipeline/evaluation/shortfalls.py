"""Where an iteration does less than three laps without damage, and how the drives ended there."""

from dataclasses import dataclass

from pipeline.evaluation.outcomes import Outcome
from pipeline.evaluation.results import STRATEGIES, Iteration
from pipeline.evaluation.summary import CONDITIONS, LAPS, Performance, measure
from pipeline.policies.strategies import Strategy


@dataclass(frozen=True)
class Shortfall:
    """A strategy, condition and track where laps are missing or there is damage."""

    strategy: Strategy
    condition: str
    track: str
    performance: Performance
    left: int
    """drives that ended by leaving the road"""
    stuck: int
    """drives that ended on the road before LAPS were done: stood still, or out of time"""
    hit: int
    """drives with damage"""


def shortfalls(iteration: Iteration) -> list[Shortfall]:
    """All of them, by strategy, condition and track."""
    cases = [
        _judge(strategy, where, track, iteration.drives_of(strategy, where, track))
        for strategy in STRATEGIES
        for where in CONDITIONS
        for track in iteration.tracks
    ]
    return [case for case in cases if case.performance.laps < LAPS or case.hit]


def _judge(strategy: Strategy, where: str, track: str, drives: list[Outcome]) -> Shortfall:
    return Shortfall(
        strategy,
        where,
        track,
        measure(drives),
        left=sum(drive.off_road for drive in drives),
        stuck=sum(drive.laps < LAPS and not drive.off_road for drive in drives),
        hit=sum(drive.damage > 0 for drive in drives),
    )
