"""Evaluation drives (Sec. 4.4): each scenario of a task by each strategy, in all its conditions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from pipeline.policies.inference import Driver
from pipeline.policies.measures import deviation, half_range
from pipeline.rollout.plans import Plan, driven, stream
from pipeline.rollout.rules.rule import Rule
from pipeline.task import Task


@dataclass(frozen=True)
class Trial:
    """A drive of an evaluation."""

    plan: Plan
    condition: str
    """one of the task's"""
    settings: Mapping[str, float]
    """the numbers in which the task's conditions differ"""
    start: int
    """number of the start: equal starts are equal situations, whoever drives"""


def trials(
    task: Task, among: Sequence[str], rules: Sequence[Rule], starts: int, *, seed: int
) -> Iterator[Trial]:
    """Every drive of an evaluation: rules x conditions x scenarios x starts.

    Every policy meets the same starts, `among` whichever of the task's conditions.
    """
    conditions = task.conditions
    told = {condition: asdict(there) for condition, there in conditions.items()}
    varied = [
        name
        for name, value in asdict(task).items()
        if isinstance(value, int | float) and len({each[name] for each in told.values()}) > 1
    ]
    for rule in rules:
        for condition in among:
            there = conditions[condition]
            settings = {name: told[condition][name] for name in varied}
            for number, scenario in enumerate(there.scenarios):
                for start in range(starts):
                    begun = stream("evaluation") + start
                    plan = Plan(there, scenario, rule, (seed, begun, number))
                    yield Trial(plan, condition, settings, start)


def evaluate(trial: Trial, driver: Driver) -> dict[str, Any]:
    """Drive once and keep the figures only: a row for `drives.table`, but for who drove."""
    plan = trial.plan
    by_reference: list[bool] = []
    epsilon = 0.0
    half_ranges = half_range(plan.task.features["action"])
    for _, frame in driven(plan, driver):
        by_reference.append(frame.intervention)
        if not frame.intervention:
            pair = frame.primary_action[None], frame.reference_action[None]
            epsilon += float(deviation(plan.task.measure, *pair, half_ranges)[0])
    return {
        "scenario": plan.scenario,
        "condition": trial.condition,
        **trial.settings,
        "strategy": plan.rule.name,
        "start": trial.start,
        "frames": len(by_reference),
        "takeover_frames": sum(by_reference),
        "primary_frames": len(by_reference) - sum(by_reference),
        "takeovers": sum(now and not before for before, now in pairwise([False, *by_reference])),
        "switches": sum(now != before for before, now in pairwise(by_reference)),
        "deviation_sum": epsilon,
        **{name: float(value) for name, value in frame.outcome.items()},
        "ended": frame.ended,
    }
