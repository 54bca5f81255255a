"""An experiment that has everything there can be."""

from dataclasses import replace

import pytest

from pipeline.evaluation.experiment import VARIANTS, Experiment, Step
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import GOOD, changed, experiment, scattered

TABLE = {run: scattered(list(levels)) for run, levels in GOOD.items()}


@pytest.fixture(scope="session")
def whole() -> Experiment:
    """Everything there can be, scattered, on two seeds."""
    return changed(experiment(TABLE, seeds=2, starts=2), with_optimal)


def with_optimal(step: Step) -> Step:
    """Drives like the safe ones, with half of the takeover; not in variants, as in the experiment."""
    if step.run in VARIANTS[1:]:
        return step
    added = [
        replace(
            drive,
            strategy=Strategy.OPTIMAL,
            takeover_frames=drive.takeover_frames // 2,
            primary_frames=drive.frames - drive.takeover_frames // 2,
        )
        for drive in step.drives
        if drive.strategy == Strategy.SAFE
    ]
    return replace(step, drives=step.drives + added)
