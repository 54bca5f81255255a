"""An experiment that has everything there can be."""

import pytest

from pipeline.evaluation.experiment import Experiment, Step
from tests.evaluation import made_up
from tests.evaluation.made_up import GOOD, VARIANTS, changed, experiment, scattered

TABLE = {run: scattered(list(levels)) for run, levels in GOOD.items()}


@pytest.fixture(scope="session")
def whole() -> Experiment:
    """Everything there can be, scattered, on two seeds."""
    return changed(experiment(TABLE, seeds=2, starts=2), with_optimal)


def with_optimal(step: Step) -> Step:
    """Drives like the safe ones, with half of the takeover; not in variants, as in the experiment."""
    if step.run in VARIANTS[1:]:
        return step
    return made_up.with_optimal(
        step,
        takeover_frames=lambda safe: safe.takeover_frames // 2,
        primary_frames=lambda safe: safe.frames - safe.takeover_frames,
    )
