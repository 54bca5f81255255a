"""Evaluation drives (Sec. 4.4): up to some laps on each track, by each strategy, without and with
traffic.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from pipeline.driving.task import Driving
from pipeline.evaluation.outcomes import Outcome
from pipeline.policies.inference import Driver
from pipeline.rollout.plans import SEED_STREAMS, Plan, driven
from pipeline.rollout.rules.rule import Rule


def plans(
    task: Driving, rules: Sequence[Rule], starts: int, *, seed: int
) -> Iterator[tuple[Plan, int]]:
    """Every drive of an evaluation, with the number of its start: rules x conditions x tracks x
    starts. The conditions are without traffic and with the task's.

    Every policy meets the same starts and the same traffic.
    """
    for rule in rules:
        for among in (replace(task, traffic=0), task):
            for number, track in enumerate(among.scenarios):
                for start in range(starts):
                    stream = SEED_STREAMS["evaluation"] + start
                    yield Plan(among, track, rule, (seed, stream, number)), start


def evaluate(plan: Plan, start: int, driver: Driver) -> Outcome:
    """Drive once and keep the figures only."""
    task = plan.task
    assert isinstance(task, Driving)
    by_reference: list[bool] = []
    squared_error = 0.0
    for _, frame in driven(plan, driver):
        by_reference.append(frame.intervention)
        if not frame.intervention:
            pair = frame.primary_action[None], frame.reference_action[None]
            squared_error += float(task.deviation(*pair)[0])
    takeovers = sum(now and not before for before, now in pairwise([False, *by_reference]))
    return Outcome(
        track=plan.scenario,
        traffic=task.traffic,
        strategy=plan.rule.name,
        start=start,
        laps=min(max(frame.outcome["laps"], 0.0), task.laps),
        damage=frame.outcome["damage"],
        frames=len(by_reference),
        takeover_frames=sum(by_reference),
        squared_error_sum=squared_error,
        primary_frames=len(by_reference) - sum(by_reference),
        takeovers=takeovers,
        switches=sum(now != before for before, now in pairwise(by_reference)),
        off_road=bool(frame.outcome["off_road"]),
    )
