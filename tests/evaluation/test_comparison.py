"""What a cell holds, and what is paired with what."""

from dataclasses import replace

import pandas as pd
import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, Contrast, contrast, estimate
from pipeline.evaluation.drives import among, table
from pipeline.evaluation.statistics import Estimate
from pipeline.evaluation.summary import CONDITIONS, measure
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import Level, experiment, of_steps, only, redriven
from tests.evaluation.sample import outcome

TABLE = {
    "safedagger": [Level(laps=(1.0, 0.5)), Level(laps=(2.0, 1.0), scatter=0.5)],
    "dagger": [Level(laps=(1.0, 0.5)), Level(laps=(1.5, 1.0), queries=0)],
}


def cell(run: str, *iterations: int, conditions: tuple[str, ...] = ("no_traffic",)) -> Cell:
    return Cell(run, iterations, Strategy.NAIVE, conditions)


@pytest.mark.parametrize("metric", [m for m in METRICS if m != "laps_iqm"])
@pytest.mark.parametrize("where", CONDITIONS)
def test_one_seed_gives_the_metrics_of_the_summary(metric: str, where: str) -> None:
    made_up = experiment(TABLE)
    drives = among(made_up.steps[0, "safedagger", 1].drives, strategy="safe", condition=where)
    expected = measure(drives, METRICS)[metric]
    found = estimate(made_up, metric, Cell("safedagger", (1,), Strategy.SAFE, (where,)))
    assert (found and found.value) == (expected and pytest.approx(expected))


def test_laps_over_iterations_and_conditions_are_averaged() -> None:
    made_up = experiment(TABLE, seeds=2)
    found = estimate(made_up, "laps", cell("dagger", 0, 1, conditions=CONDITIONS))
    assert found == Estimate(1.0, 1.0, 1.0, 24)


def test_the_interquartile_mean_leaves_out_what_failed() -> None:
    steps = dict(experiment(TABLE).steps)
    step = steps[0, "dagger", 1]
    steps[0, "dagger", 1] = redriven(step, {"laps": 0.0}, start=0)
    mean, middle = (
        estimate(of_steps(steps), metric, cell("dagger", 1)) for metric in ("laps", "laps_iqm")
    )
    assert mean and middle and (mean.value, middle.value) == (1.125, 1.5)


def test_pairs_are_those_that_both_have() -> None:
    """Seed 1 has no DAgger, and DAgger no drive of yew."""
    steps = dict(experiment(TABLE, seeds=2).steps)
    del steps[1, "dagger", 1]
    step = steps[0, "dagger", 1]
    steps[0, "dagger", 1] = only(step, scenario=["spruce", "willow"])
    found = contrast(of_steps(steps), "laps", cell("safedagger", 0), cell("dagger", 1))
    assert found == Contrast(1.0, 1.5, Estimate(-0.5, -0.5, -0.5, 8))


def test_what_is_missing_or_not_defined_is_none() -> None:
    made_up = experiment(TABLE)
    assert estimate(made_up, "laps", cell("supervised", 1)) is None
    assert estimate(made_up, "laps", cell("dagger", 1, 2)) is None
    assert estimate(made_up, "takeover_length", cell("dagger", 1)) is None
    assert contrast(made_up, "laps", cell("dagger", 1), cell("supervised", 1)) is None
    assert contrast(made_up, "takeover_length", cell("dagger", 1), cell("dagger", 0)) is None


def test_the_order_of_seeds_and_drives_does_not_matter() -> None:
    made_up = experiment(TABLE, seeds=2)
    steps = {
        key: replace(step, drives=step.drives[::-1])
        for key, step in reversed(list(made_up.steps.items()))
    }
    for metric in METRICS:
        cells = cell("safedagger", 1), cell("dagger", 1)
        assert estimate(of_steps(steps), metric, cells[0]) == estimate(made_up, metric, cells[0])
        assert contrast(of_steps(steps), metric, *cells) == contrast(made_up, metric, *cells)


def test_two_drives_of_one_situation_are_refused() -> None:
    steps = dict(experiment(TABLE).steps)
    step = steps[0, "dagger", 1]
    twice = pd.concat([step.drives, table([outcome()])])
    steps[0, "dagger", 1] = replace(step, drives=twice)
    problem = "seed 0, dagger, iteration 1: two drives of naive, no_traffic, yew, start 0"
    with pytest.raises(ValueError, match=f"{problem}, expected one"):
        estimate(of_steps(steps), "laps", cell("dagger", 1))
