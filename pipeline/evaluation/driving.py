"""Evaluation drives (Sec. 4.4): up to some laps on each track, by each strategy, without and with
traffic.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from pipeline.evaluation.outcomes import Outcome
from pipeline.policies.inference import Driver
from pipeline.rollout.recording import SEED_STREAMS, Drive, driven
from pipeline.rollout.strategies import Rule


def plans(
    rules: Sequence[Rule],
    tracks: Sequence[str],
    traffic: int,
    starts: int,
    *,
    record_every: int,
    laps: float,
    seconds: float,
    seed: int,
) -> Iterator[tuple[Drive, int]]:
    """Every drive of an evaluation, with the number of its start: rules x conditions x tracks x
    starts.

    Every policy meets the same starts and the same traffic.
    """
    for rule in rules:
        for cars in (0, traffic):
            for number, track in enumerate(tracks):
                for start in range(starts):
                    yield (
                        Drive(
                            track=track,
                            traffic=cars,
                            spread=(0.0, 0.0),
                            seed=(seed, SEED_STREAMS["evaluation"] + start, number),
                            rule=rule,
                            record_every=record_every,
                            laps=laps,
                            seconds=seconds,
                        ),
                        start,
                    )


def evaluate(plan: Drive, start: int, driver: Driver) -> Outcome:
    """Drive once and keep the figures only."""
    by_reference: list[bool] = []
    squared_error = 0.0
    for world, frame in driven(plan, driver):  # noqa: B007 (the world is read after the last frame)
        by_reference.append(frame.intervention)
        squared_error += 0.0 if frame.intervention else frame.squared_error
    takeovers = sum(now and not before for before, now in pairwise([False, *by_reference]))
    return Outcome(
        track=plan.track,
        traffic=plan.traffic,
        strategy=plan.rule.strategy,
        start=start,
        laps=min(max(world.laps, 0.0), plan.laps),
        damage=world.damage,
        frames=len(by_reference),
        takeover_frames=sum(by_reference),
        squared_error_sum=squared_error,
        primary_frames=len(by_reference) - sum(by_reference),
        takeovers=takeovers,
        switches=sum(now != before for before, now in pairwise(by_reference)),
        off_road=world.off_road,
    )
