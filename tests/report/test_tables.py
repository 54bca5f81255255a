"""Each table holds the numbers of its inputs."""

from dataclasses import replace
from functools import partial

import pytest

from pipeline.data.ledger import Ledger
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import Experiment, Step
from pipeline.evaluation.metrics_file import SafetyQuality
from pipeline.evaluation.wording import laps
from pipeline.report.material import ErrorShares
from pipeline.report.threshold import RUN
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import (
    FULL,
    GOOD,
    GROWING,
    SLOW,
    SPECS,
    TITLES,
    VARIANTS,
    changed,
    experiment,
    of_steps,
    redriven,
    scattered,
    with_optimal,
)
from tests.report.rendered import report, rows, section

TABLES = {
    "Laps, naive": 2,
    "Damage per lap, naive": 2,
    "Steering MSE, naive": 4,
    "Takeover, safe": 1,
    "Switches per lap, safe": 1,
    "Frames of a takeover, safe": 1,
    "Queries so far": 5,
}


def numbers(text: str) -> str:
    """The tables with a row for each run and iteration."""
    return section(text, "In numbers")


@pytest.mark.parametrize("header", TABLES)
def test_every_run_and_iteration_has_its_row(header: str) -> None:
    made_up = experiment({run: levels for run, levels in GOOD.items() if run != "dagger"})
    found = rows(numbers(report(made_up)), header)
    assert list(found) == [
        (TITLES[run], str(i)) for run in SPECS if run != "dagger" for i in range(4)
    ]
    assert {len(cells) for cells in found.values()} == {TABLES[header]}


def test_laps_have_their_intervals_in_both_conditions() -> None:
    made_up = changed(experiment({"dagger": scattered(SLOW)}), partial(with_optimal, laps=2.5))
    naive, safe, optimal = rows(numbers(report(made_up)), "Laps, naive")["DAgger", "2"]
    expected = []
    for where in ("no_traffic", "traffic"):
        one = estimate(made_up, "laps", Cell("dagger", (2,), Strategy.NAIVE, (where,)))
        assert one and one.low < one.high
        expected.append(f"{laps(one.value)} [{laps(one.low)}, {laps(one.high)}]")
    assert naive == " / ".join(expected)
    assert safe.startswith("2.70 [")
    assert optimal == "2.50 / 2.50"


def test_every_metric_is_in_its_table() -> None:
    def driven(step: Step) -> Step:
        hit = redriven(step, {"damage": lambda d: 3 * d.laps}, strategy="naive")
        return redriven(hit, {"takeovers": 20, "switches": 39}, strategy="safe")

    text = numbers(report(changed(experiment({"dagger": SLOW}, starts=2), driven)))
    same = "{0} / {1}".format
    first = ("DAgger", "0")
    assert rows(text, "Damage per lap, naive")[first] == [same(3, 3), same(0, 0)]
    assert rows(text, "Steering MSE, naive")[first] == [
        same(0.02, 0.03),
        same(0.02, 0.03),
        "6,000 / 6,000",
        "5,520 / 4,800",
    ]
    assert rows(text, "Takeover, safe")[first] == [same("8.0 %", "20.0 %")]
    assert rows(text, "Switches per lap, safe")[first] == [same(13, 13)]
    assert rows(text, "Frames of a takeover, safe")[first] == [same(4, 10)]


def test_the_cost_is_that_of_the_loop_and_the_mean_over_the_seeds() -> None:
    def dearer(step: Step) -> Step:
        driven = 1000 * step.iteration + 100 * step.seed
        trained = 2000 + 10 * step.iteration
        return replace(
            step, ledger=replace(step.ledger, frames_driven=driven, frames_trained=trained)
        )

    made_up = changed(experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2), dearer)
    d_safe = {seed: Ledger(1, 5000 + 200 * seed, 1, 1, 1.0) for seed in (0, 1)}
    found = rows(report(made_up, d_safe=d_safe), "Queries so far")
    assert found["SafeDAgger", "0"] == ["0", "8,100", "0", "-", "2,000"]
    assert found["SafeDAgger", "1"] == ["3,000", "11,100", "1,050", "30.0 %", "2,010"]
    assert found["SafeDAgger", "3"] == ["7,000", "15,100", "6,150", "30.0 %", "2,030"]
    # its safety policies, and hence D_safe, exist only to measure
    assert found["DAgger", "0"][:2] == ["0", "3,000"]
    assert found["DAgger", "3"][:2] == ["35,000", "38,000"]


def test_the_safety_policies_on_held_out_frames_and_in_the_next_rollout() -> None:
    """Of SafeDAgger and its variants; the mean over the seeds that have the number."""

    def judged(step: Step) -> Step:
        held_out = SafetyQuality(0.8 + 0.1 * step.seed, 0.6, None, 0.2, 0.3)
        rollout = SafetyQuality(0.7, 0.4, None if step.seed else 0.5, 0.25, 0.35)
        return replace(
            step,
            tau=0.0025 * (1 + step.iteration),
            held_out=held_out,
            next_rollout=None if step.iteration == 3 else rollout,
        )

    found = rows(report(changed(experiment(GOOD, seeds=2), judged)), "AUROC")
    assert list(found) == [(TITLES[run], str(i)) for run in VARIANTS for i in range(4)]
    assert found["SafeDAgger, rising tau", "1"] == [
        "0.005",
        "0.85 / 0.70",
        "60.0 % / 40.0 %",
        "- / 50.0 %",
        "20.0 % / 25.0 %",
        "30.0 % / 35.0 %",
    ]
    assert found["SafeDAgger", "3"][1:3] == ["0.85 / -", "60.0 % / -"]


def test_the_thresholds_are_side_by_side() -> None:
    def told_apart(made_up: Experiment, share: float | None) -> Experiment:
        quality = SafetyQuality(None, None, None, share, None)
        return of_steps(
            {
                (seed, RUN, 0): replace(step, run=RUN, held_out=quality)
                for (seed, _, _), step in made_up.steps.items()
            }
        )

    first, last = (
        experiment({"safedagger": GROWING[:1]}, seeds=2),
        experiment({"safedagger": GROWING[3:]}),
    )
    thresholds = {0.000625: told_apart(first, 0.417), 0.04: told_apart(last, None)}
    found = section(report(experiment(GOOD), thresholds=thresholds), "Other thresholds")
    strict, lax = found.strip().splitlines()[-2:]
    assert strict.startswith("| 0.000625 | 0, 1 | 41.7 % | 3.00 / 3.00")
    assert "| 8.0 % / 20.0 % |" in strict
    assert lax.startswith("| 0.04 | 0 | - | 3.00")
    assert "| 2.0 % / 5.0 % |" in lax


def test_which_errors_are_safe_by_seed() -> None:
    errors = {
        1: ErrorShares(0.01, 0.99, 0.9, share=None, tau_for_share=None),
        0: ErrorShares(0.0025, 0.961, 0.8425, share=0.777, tau_for_share=0.00168123),
    }
    text = report(experiment({"safedagger": GROWING}, seeds=2), errors=errors)
    found = section(text, "Which errors are safe").strip().splitlines()
    assert found[-2:] == [
        "| 0 | 0.0025 | 96.1 % | 84.2 % | 0.00168 (77.7 %) |",
        "| 1 | 0.01 | 99.0 % | 90.0 % | - |",
    ]
    assert "- Seed 1: no tau for the paper's share of safe frames in errors.json." in text


def test_track_by_track_after_the_last_iteration_over_all_seeds() -> None:
    def slower_on_yew(step: Step) -> Step:
        slow = {"laps": 1.0 + step.seed, "damage": 3.0}
        return redriven(step, slow, scenario="yew", condition="traffic")

    made_up = experiment({"dagger": SLOW[:2], "safedagger": [*GROWING, FULL]}, seeds=2)
    text = section(
        report(changed(made_up, slower_on_yew)), "Track by track, after the last iteration"
    )
    found = rows(text, "Takeover, safe")
    assert list(found) == [
        (run, track) for run in ("SafeDAgger", "DAgger") for track in ("spruce", "willow", "yew")
    ]
    assert found["DAgger", "spruce"] == ["2.10 / 1.60", "3.00 / 3.00", "0 / 0", "7.5 % / 19.0 %"]
    assert found["SafeDAgger", "yew"] == ["3.00 / 1.50", "3.00 / 1.50", "0 / 2", "2.0 % / 5.0 %"]


def test_a_track_without_drives_of_a_strategy_has_no_number() -> None:
    made_up = experiment({"safedagger": [FULL]})
    step = made_up.steps[0, "safedagger", 0]
    kept = step.drives.query("scenario != 'yew' or strategy == 'naive'")
    text = report(of_steps({(0, "safedagger", 0): replace(step, drives=kept)}))
    found = rows(section(text, "Track by track, after the last iteration"), "Takeover, safe")
    assert found["SafeDAgger", "yew"] == ["3.00 / 3.00", "- / -", "0 / 0", "- / -"]
