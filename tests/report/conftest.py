"""An experiment that has everything there can be."""

import pytest

from pipeline.evaluation.experiment import Experiment
from tests.evaluation.made_up import GOOD, SPECS, VARIANTS, experiment, scattered, with_optimal

TABLE = {run: scattered(list(levels)) for run, levels in GOOD.items()}


@pytest.fixture(scope="session")
def whole() -> Experiment:
    """Everything there can be, scattered, on two seeds."""
    return halved(experiment(TABLE, seeds=2, starts=2))


def halved(made_up: Experiment) -> Experiment:
    """With optimal drives of half the takeover; not in variants, as in the experiment."""
    return with_optimal(
        made_up,
        [run for run in SPECS if run not in VARIANTS[1:]],
        takeover_frames=lambda safe: safe.takeover_frames // 2,
        primary_frames=lambda safe: safe.frames - safe.takeover_frames,
    )
