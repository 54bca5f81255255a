"""What the report rests on, and how sure it is."""

from dataclasses import replace

import pytest

from pipeline.evaluation.experiment import D_SAFE
from tests.evaluation.made_up import FRAMES, GOOD, GROWING, experiment, reckoned
from tests.report.rendered import report

ALONE = {"safedagger": GROWING}


@pytest.fixture(scope="module")
def good() -> str:
    return report(experiment(GOOD, seeds=2, starts=3))


@pytest.fixture(scope="module")
def alone() -> str:
    return report(experiment(ALONE, starts=1))


def block(text: str, beginning: str) -> str:
    (found,) = (part for part in text.split("\n\n") if part.startswith(beginning))
    return found


def test_what_was_asked_only_to_measure_stands_apart() -> None:
    """By seed 0: 500 frames of a rollout without a query, seed 1: 1,500."""

    changes = {
        "frames_driven": lambda of: of.queries + (500 + 1000 * of.seed) * (of.iteration == 1),
        "frames_trained": lambda of: 2000 + 10 * of.iteration,
    }
    made_up = reckoned(experiment(ALONE, seeds=2, starts=1), changes, run="safedagger")
    made_up = reckoned(made_up, {"queries": lambda of: 5000 + 200 * of.seed}, run=D_SAFE)
    cost = block(report(made_up), "**Cost.**")
    assert (
        "SafeDAgger asked 7,000 queries a seed, on average, in 8,000 frames driven, after 3,000 "
        "queries for D_0 and 5,100 for D_safe; its last primary was trained on 2,030 frames."
        in cost
    )
    # naive drives, and what the reference did not drive of the safe ones
    naive = 2 * 4 * 6 * FRAMES
    safe = 2 * 3 * sum(round(FRAMES * (2 - sum(level.takeover))) for level in GROWING)
    assert f"asked in 2,000 frames of rollouts and {naive + safe:,} of evaluation" in cost


def test_what_it_rests_on(good: str, alone: str) -> None:
    """Iteration 0 is shared: 22 steps of 36 drives on each seed."""
    basis = block(good, "**Basis.**")
    assert "Seeds 0, 1. Test tracks: spruce, willow, yew. Starts on each: 3." in basis
    assert "Traffic: 40 cars. 1,584 drives: naive, in which" in basis
    assert "Each seed again: `make experiment SEED=0`, `make experiment SEED=1`." in basis
    assert "make repro" not in basis
    basis = block(alone, "**Basis.**")
    assert basis.startswith("**Basis.** Seed 0. ")
    assert "Each seed again: `make repro`, with this `seed` in `params.yaml`;" in basis
    assert "`make experiment SEED=0`" in basis


def test_where_no_condition_has_traffic_there_is_no_column_of_it() -> None:
    made_up = experiment(ALONE)
    quiet = replace(made_up, drives=made_up.drives.drop(columns="traffic"))
    assert "Traffic: no cars." in block(report(quiet), "**Basis.**")


def test_that_all_went_well_is_no_certainty(good: str, alone: str) -> None:
    """Of 18 drives in a cell, 15.3 % can fail without one failing here, once in 20 times."""
    intervals = block(good, "**Intervals.**")
    assert "rests on 18 drives at most" in intervals
    assert "18 drives that all went well still allow that 15 % would fail" in intervals
    assert "one seed" not in intervals
    intervals = block(alone, "**Intervals.**")
    assert "3 drives that all went well still allow that 63 % would fail" in intervals
    assert "With one seed, no interval" in intervals
