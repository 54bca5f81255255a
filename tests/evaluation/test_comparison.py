"""What a cell holds, and what is paired with what."""

from collections.abc import Iterable
from dataclasses import replace

import pandas as pd
import pytest

from pipeline.driving.metrics import CONDITIONS, METRICS
from pipeline.evaluation.comparison import Cell, Contrast, contrast, estimate
from pipeline.evaluation.statistics import Estimate
from pipeline.evaluation.summary import measure
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import Level, experiment, redriven, undriven, without

TABLE = {
    "safedagger": [Level(laps=(1.0, 0.5)), Level(laps=(2.0, 1.0), scatter=0.5)],
    "dagger": [Level(laps=(1.0, 0.5)), Level(laps=(1.5, 1.0), queries=0)],
}


def cell(run: str, *iterations: int, conditions: Iterable[str] = ("no_traffic",)) -> Cell:
    return Cell(run, iterations, Strategy.NAIVE, tuple(conditions))


@pytest.mark.parametrize("metric", [m for m in METRICS if m != "laps_iqm"])
@pytest.mark.parametrize("where", CONDITIONS)
def test_one_seed_gives_the_metrics_of_the_summary(metric: str, where: str) -> None:
    made_up = experiment(TABLE)
    here = {"run": "safedagger", "iteration": 1, "strategy": "safe", "condition": where}
    drives = made_up.among(**here)
    expected = measure(drives, METRICS)[metric]
    found = estimate(made_up, metric, Cell("safedagger", (1,), Strategy.SAFE, (where,)))
    assert (found and found.value) == (expected and pytest.approx(expected))


def test_laps_over_iterations_and_conditions_are_averaged() -> None:
    made_up = experiment(TABLE, seeds=2)
    found = estimate(made_up, "laps", cell("dagger", 0, 1, conditions=CONDITIONS))
    assert found == Estimate(1.0, 1.0, 1.0, 24)


def test_the_interquartile_mean_leaves_out_what_failed() -> None:
    made_up = redriven(experiment(TABLE), {"laps": 0.0}, run="dagger", iteration=1, start=0)
    mean, middle = (estimate(made_up, each, cell("dagger", 1)) for each in ("laps", "laps_iqm"))
    assert mean and middle and (mean.value, middle.value) == (1.125, 1.5)


def test_pairs_are_those_that_both_have() -> None:
    """Seed 1 has no DAgger, and DAgger no drive of yew."""
    alone = without(experiment(TABLE, seeds=2), seed=1, run="dagger", iteration=1)
    made_up = undriven(alone, run="dagger", iteration=1, scenario="yew")
    found = contrast(made_up, "laps", cell("safedagger", 0), cell("dagger", 1))
    assert found == Contrast(1.0, 1.5, Estimate(-0.5, -0.5, -0.5, 8), most=3.0)


def test_what_is_missing_or_not_defined_is_none() -> None:
    made_up = experiment(TABLE)
    assert estimate(made_up, "laps", cell("supervised", 1)) is None
    assert estimate(made_up, "laps", cell("dagger", 1, 2)) is None
    assert estimate(made_up, "takeover_length", cell("dagger", 1)) is None
    assert contrast(made_up, "laps", cell("dagger", 1), cell("supervised", 1)) is None
    assert contrast(made_up, "takeover_length", cell("dagger", 1), cell("dagger", 0)) is None


def test_the_order_of_seeds_and_drives_does_not_matter() -> None:
    made_up = experiment(TABLE, seeds=2)
    backwards = replace(made_up, drives=made_up.drives[::-1])
    for metric in METRICS:
        cells = cell("safedagger", 1), cell("dagger", 1)
        assert estimate(backwards, metric, cells[0]) == estimate(made_up, metric, cells[0])
        assert contrast(backwards, metric, *cells) == contrast(made_up, metric, *cells)


def test_two_drives_of_one_situation_are_refused() -> None:
    made_up = experiment(TABLE)
    twice = made_up.among(run="dagger", iteration=1)[:1]
    made_up = replace(made_up, drives=pd.concat([made_up.drives, twice]))
    with pytest.raises(
        ValueError, match="seed 0, dagger, iteration 1: two drives of naive, no_traffic"
    ):
        estimate(made_up, "laps", cell("dagger", 1))
