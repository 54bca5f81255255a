"""What a cell holds, and what is paired with what."""

from dataclasses import replace

import pytest

from pipeline.evaluation.comparison import METRICS, Cell, Contrast, contrast, estimate
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import Estimate
from pipeline.evaluation.summary import CONDITIONS, Performance, measure
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import Level, experiment
from tests.evaluation.sample import outcome

TABLE = {
    "safedagger": [Level(laps=(1.0, 0.5)), Level(laps=(2.0, 1.0), scatter=0.5)],
    "dagger": [Level(laps=(1.0, 0.5)), Level(laps=(1.5, 1.0), queries=0)],
}


def cell(run: str, *iterations: int, conditions: tuple[str, ...] = ("no_traffic",)) -> Cell:
    return Cell(run, iterations, Strategy.NAIVE, conditions)


@pytest.mark.parametrize("metric", METRICS.keys() - {"laps_iqm"})
@pytest.mark.parametrize("where", CONDITIONS)
def test_one_seed_gives_the_metrics_of_the_summary(metric: str, where: str) -> None:
    made_up = experiment(TABLE)
    drives = [d for d in made_up.steps[0, "safedagger", 1].drives if d.strategy == Strategy.SAFE]
    expected = getattr(
        measure(d for d in drives if (d.traffic > 0) == (where == "traffic")), metric
    )
    found = estimate(made_up, metric, Cell("safedagger", (1,), Strategy.SAFE, (where,)))
    assert (found and found.value) == (expected and pytest.approx(expected))


def test_metrics_have_the_names_of_the_summary() -> None:
    assert METRICS.keys() - {"laps_iqm"} <= Performance.__annotations__.keys()


def test_laps_over_iterations_and_conditions_are_averaged() -> None:
    made_up = experiment(TABLE, seeds=2)
    found = estimate(made_up, "laps", cell("dagger", 0, 1, conditions=CONDITIONS))
    assert found == Estimate(1.0, 1.0, 1.0, 24)


def test_the_interquartile_mean_leaves_out_what_failed() -> None:
    steps = dict(experiment(TABLE).steps)
    step = steps[0, "dagger", 1]
    lost = [replace(d, laps=0.0) if d.start == 0 else d for d in step.drives]
    steps[0, "dagger", 1] = replace(step, drives=lost)
    mean, middle = (
        estimate(Experiment(steps), metric, cell("dagger", 1)) for metric in ("laps", "laps_iqm")
    )
    assert mean and middle and (mean.value, middle.value) == (1.125, 1.5)


def test_pairs_are_those_that_both_have() -> None:
    """Seed 1 has no DAgger, and DAgger no drive of yew."""
    steps = dict(experiment(TABLE, seeds=2).steps)
    del steps[1, "dagger", 1]
    step = steps[0, "dagger", 1]
    steps[0, "dagger", 1] = replace(step, drives=[d for d in step.drives if d.track != "yew"])
    found = contrast(Experiment(steps), "laps", cell("safedagger", 0), cell("dagger", 1))
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
        assert estimate(Experiment(steps), metric, cells[0]) == estimate(made_up, metric, cells[0])
        assert contrast(Experiment(steps), metric, *cells) == contrast(made_up, metric, *cells)


def test_two_drives_of_one_situation_are_refused() -> None:
    steps = dict(experiment(TABLE).steps)
    step = steps[0, "dagger", 1]
    steps[0, "dagger", 1] = replace(step, drives=[*step.drives, outcome()])
    problem = "seed 0, dagger, iteration 1: two drives of naive, no_traffic, yew, start 0"
    with pytest.raises(ValueError, match=f"{problem}, expected one"):
        estimate(Experiment(steps), "laps", cell("dagger", 1))
