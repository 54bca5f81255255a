"""Evaluation drives (Sec. 4.4): up to some laps on each track, naive and safe, without and with
traffic.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pipeline.evaluation.outcomes import Outcome
from pipeline.policies.inference import Driver
from pipeline.policies.recording import SEED_STREAMS, Drive, driven
from pipeline.policies.strategies import Strategy


def plans(
    tracks: Sequence[str],
    traffic: int,
    starts: int,
    *,
    cut: float,
    record_every: int,
    laps: float,
    seconds: float,
    seed: int,
) -> Iterator[tuple[Drive, int]]:
    """Every drive of an evaluation, with the number of its start: strategies x conditions x tracks
    x starts.

    Every policy meets the same starts and the same traffic.
    """
    for strategy in (Strategy.NAIVE, Strategy.SAFE):
        for cars in (0, traffic):
            for number, track in enumerate(tracks):
                for start in range(starts):
                    yield (
                        Drive(
                            track=track,
                            traffic=cars,
                            spread=(0.0, 0.0),
                            seed=(seed, SEED_STREAMS["evaluation"] + start, number),
                            strategy=strategy,
                            cut=cut,
                            record_every=record_every,
                            laps=laps,
                            seconds=seconds,
                        ),
                        start,
                    )


def evaluate(plan: Drive, start: int, driver: Driver) -> Outcome:
    """Drive once and keep the figures only."""
    frames = takeovers = 0
    squared_error = 0.0
    for world, frame in driven(plan, driver):  # noqa: B007 (the world is read after the last frame)
        frames += 1
        takeovers += frame.intervention
        squared_error += 0.0 if frame.intervention else frame.squared_error
    return Outcome(
        track=plan.track,
        traffic=plan.traffic,
        strategy=plan.strategy,
        start=start,
        laps=min(max(world.laps, 0.0), plan.laps),
        damage=world.damage,
        frames=frames,
        takeover_frames=takeovers,
        squared_error_sum=squared_error,
        primary_frames=frames - takeovers,
        off_road=world.off_road,
    )
