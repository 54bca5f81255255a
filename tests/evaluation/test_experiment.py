"""What an experiment knows of its runs, and what each step cost so far."""

import math
from dataclasses import replace

import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from tests.evaluation.made_up import COMPARISON, GROWING, experiment, reckoned

BOTH = experiment({"safedagger": GROWING, "dagger": GROWING}, starts=1)


def test_runs_come_in_the_order_in_which_they_were_told() -> None:
    found = experiment(dict.fromkeys(("supervised", "dagger_budget", "safedagger"), GROWING))
    assert found.runs == [run for run in COMPARISON.runs if run in found.runs]
    assert found.ours == "safedagger"
    assert found.strategies == ["safedagger", "dagger", "dagger_budget", "supervised"]
    assert found.variants[0] == "safedagger" and len(found.variants) == 4
    nothing = Experiment(specs={})
    assert nothing.runs == [] and nothing.ours is None


def test_a_metric_is_at_most_what_the_task_sets() -> None:
    assert (BOTH.most(METRICS["laps"]), BOTH.most(METRICS["takeover"])) == (3, math.inf)
    endless = replace(BOTH, drives=BOTH.drives.assign(**{"task.laps": math.inf}))
    assert endless.most(METRICS["laps"]) == math.inf


def test_what_was_spent_is_that_of_the_loop_so_far() -> None:
    """And the labels in all: D_0, the loop, D_safe where a loop needs it for a safety policy."""
    changes = {
        "frames_driven": lambda of: 1000 * of.iteration,
        "frames_trained": lambda of: 3000 + 10 * of.iteration,
        "takeover": lambda of: of.iteration / 10,
    }
    found = reckoned(BOTH, changes, run=["safedagger", "dagger"])
    ours, dagger = (among(found.spent, run=run) for run in ("safedagger", "dagger"))
    assert ours.queries.tolist() == dagger.queries.tolist() == [0, 3000, 6000, 7000]
    assert ours.frames_driven.tolist() == [0, 1000, 3000, 6000]
    assert ours.frames_trained.tolist() == [3000, 3010, 3020, 3030]
    assert ours.takeover[1:].tolist() == pytest.approx([0.1, 0.5 / 3, 1.4 / 6])
    assert ours.labels.tolist() == [8600, 11_600, 14_600, 15_600]
    assert dagger.labels.tolist() == [3000, 6000, 9000, 10_000]
    aside = found.specs["safedagger"].model_copy(update={"set_aside": 0.2})
    without = replace(found, specs={**found.specs, "safedagger": aside}).spent
    assert among(without, run="safedagger").labels.tolist() == [3000, 6000, 9000, 10_000]


def test_what_older_ledgers_did_not_count_is_unknown_from_there_on() -> None:
    """What newer ones count is summed, the failures of each kind by their names."""
    counted = {"calls": 5, "failures": 3, "failures.touches": 2, "scenarios": 7}
    older = reckoned(BOTH, counted | {"put_back": math.nan})
    older = reckoned(older, dict.fromkeys(counted, math.nan), iteration=3)
    spent = among(older.spent, run="safedagger").set_index("iteration")
    expected = {"calls": 10, "failures": 6, "failures.touches": 4, "scenarios": 7}
    for name, value in expected.items():
        assert spent[name][2] == value
        assert math.isnan(spent[name][3])
    assert spent.queries.notna().all() and spent.put_back[1:].isna().all()
