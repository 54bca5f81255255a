"""Each table holds the numbers of its inputs."""

import math
from dataclasses import replace

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import D_SAFE, HELD_OUT, ROLLOUT, Experiment, Tables
from pipeline.evaluation.files import ErrorShares
from pipeline.evaluation.wording import laps
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import (
    FULL,
    GOOD,
    GROWING,
    SLOW,
    SPECS,
    TITLES,
    VARIANTS,
    experiment,
    judged,
    reckoned,
    redriven,
    scattered,
    undriven,
    with_optimal,
)
from tests.evaluation.made_up_curves import curves
from tests.report.rendered import report, rows, section

TABLES = {
    "Laps, naive": 2,
    "Damage per lap, naive": 2,
    "Steering MSE, naive": 4,
    "Takeover, safe": 1,
    "Switches per lap, safe": 1,
    "Frames of a takeover, safe": 1,
    "Queries so far": 5,
    "Calls": 11,
}


def numbers(text: str) -> str:
    """The tables with a row for each run and iteration."""
    return section(text, "In numbers")


def test_every_run_and_iteration_has_its_row() -> None:
    made_up = experiment({run: levels for run, levels in GOOD.items() if run != "dagger"})
    text = numbers(report(made_up))
    expected = [(TITLES[run], str(i)) for run in SPECS if run != "dagger" for i in range(4)]
    for header, columns in TABLES.items():
        found = rows(text, header)
        assert list(found) == expected
        assert {len(cells) for cells in found.values()} == {columns}


def test_reliability_is_shown_with_the_drives_and_seeds_that_it_rests_on() -> None:
    made_up = experiment({"safedagger": GROWING}, seeds=2)
    text = report(made_up, relied_on=_alone(0.6, made_up))
    found = rows(section(text, "Reliability"), "Drives, seeds")
    assert [*found] == [("SafeDAgger", "0"), ("SafeDAgger", "3")]
    rests, succeeded, failed = found["SafeDAgger", "3"]
    assert (rests, succeeded) == ("80, 1", " / ".join(["60.0 % [43.3 %, 75.1 %]"] * 2))
    # of 40 drives 16 leave the road, over 1,000 m each
    assert [cell.split(" [")[0] for cell in failed.split(" / ")] == ["40", "40"]
    missing = section(text, "What is missing")
    assert "- Reliability: SafeDAgger, seed 0: no iteration 1, 2.\n" in missing
    assert "- Reliability, seed 1: not measured." in missing
    without = report(made_up)
    assert "### Reliability\n" not in without and "- Reliability, seed 0: not measured." in without


def test_reliability_in_a_crowd_stands_beside_it() -> None:
    made_up = experiment({"safedagger": GROWING})
    crowd = undriven(_alone(0.75, made_up), condition="no_traffic")
    crowd = replace(crowd, drives=crowd.drives.assign(traffic=40.0))
    text = report(made_up, in_crowd=crowd)
    assert "among 40 other cars; seed 0." in section(text, "Reliability in a crowd")
    found = rows(section(text, "Reliability in a crowd"), "Drives, seeds")
    assert found["SafeDAgger", "3"][:2] == ["40, 1", "75.0 % [58.8 %, 87.3 %]"]
    assert "Reliability in a crowd" not in section(text, "What is missing")
    assert "### Reliability in a crowd" not in report(made_up)


def test_laps_have_their_intervals_in_both_conditions() -> None:
    made_up = with_optimal(experiment({"dagger": scattered(SLOW)}), laps=2.5)
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
    hit = experiment({"dagger": SLOW}, starts=2)
    hit = redriven(hit, {"damage": lambda drives: 3 * drives.laps}, strategy="naive")
    text = numbers(report(redriven(hit, {"takeovers": 20, "switches": 39}, strategy="safe")))
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
    changes = {
        "frames_driven": lambda of: 1000 * of.iteration + 100 * of.seed,
        "frames_trained": lambda of: 2000 + 10 * of.iteration,
    }
    made_up = experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)
    made_up = reckoned(made_up, changes, run=["safedagger", "dagger"])
    made_up = reckoned(made_up, {"queries": lambda of: 5000 + 200 * of.seed}, run=D_SAFE)
    found = rows(report(made_up), "Queries so far")
    assert found["SafeDAgger", "0"] == ["0", "8,100", "0", "-", "2,000"]
    assert found["SafeDAgger", "1"] == ["3,000", "11,100", "1,050", "30.0 %", "2,010"]
    assert found["SafeDAgger", "3"] == ["7,000", "15,100", "6,150", "30.0 %", "2,030"]
    # its safety policies, and hence D_safe, exist only to measure
    assert found["DAgger", "0"][:2] == ["0", "3,000"]
    assert found["DAgger", "3"][:2] == ["35,000", "38,000"]


def test_what_collecting_took_is_that_of_the_loop_and_the_mean_over_the_seeds() -> None:
    changes = {
        "calls": lambda of: 10 * of.iteration + of.seed,
        "scenarios": lambda of: of.iteration.map({0: 9, 1: 3, 2: 7, 3: 5}),
        "failures": lambda of: of.seed * (of.iteration == 2),
    }
    made_up = reckoned(experiment({"safedagger": GROWING}, seeds=2), changes)
    found = rows(report(made_up), "Calls")
    none = ["0", "0", "0", "0"]
    assert found["SafeDAgger", "0"] == ["0", "0", "0", "-", "0", *none, "0", "0"]
    assert found["SafeDAgger", "1"] == ["4", "3", "10", "28.6", "118", *none, "0", "0"]
    assert found["SafeDAgger", "3"][:5] == ["12", "7", "62", "14.6", "354"]
    assert found["SafeDAgger", "3"][7] == "0.5"


def test_what_a_ledger_did_not_count_is_a_dash_from_there_on() -> None:
    made_up = experiment({"safedagger": GROWING})
    older = reckoned(made_up, {"calls": math.nan, "failures": math.nan}, iteration=2)
    found = rows(report(older), "Calls")
    assert [found["SafeDAgger", str(i)][2] for i in range(4)] == ["0", "60", "-", "-"]
    assert [found["SafeDAgger", str(i)][7] for i in range(4)] == ["0", "0", "-", "-"]
    nowhere = report(reckoned(made_up, {"calls": math.nan}))
    assert "| Calls |" not in nowhere and "| Queries so far |" in nowhere


def test_the_safety_policies_on_held_out_frames_and_in_the_next_rollout() -> None:
    """Of SafeDAgger and its variants; the mean over the seeds that have the number."""

    held_out = {"auroc": lambda of: 0.8 + 0.1 * of.seed, "recall": 0.6, "share_unsafe": 0.2}
    held_out |= {"share_predicted_unsafe": 0.3, "tau": lambda of: 0.0025 * (1 + of.iteration)}
    rollout = {"auroc": 0.7, "recall": 0.4, "precision": lambda of: of.seed.map({0: 0.5})}
    rollout |= {"share_unsafe": 0.25, "share_predicted_unsafe": 0.35}
    made_up = experiment({run: GOOD[run] for run in ("dagger", *VARIANTS)}, seeds=2, starts=1)
    made_up = judged(judged(made_up, HELD_OUT, held_out), ROLLOUT, rollout)
    last = (made_up.quality.judged_on == ROLLOUT) & (made_up.quality.iteration == 3)
    found = rows(report(replace(made_up, quality=made_up.quality[~last])), "AUROC")
    assert list(found) == [(TITLES[run], str(i)) for run in VARIANTS for i in range(4)]
    assert found["SafeDAgger, rising tau", "1"] == [
        "0.005",
        "0.85 / 0.70",
        "60.0 % / 40.0 %",
        "- / 50.0 %",
        "- / -",  # of older metrics: average precision and calibration error
        "- / -",
        "20.0 % / 25.0 %",
        "30.0 % / 35.0 %",
    ]
    assert found["SafeDAgger", "3"][1:3] == ["0.85 / -", "60.0 % / -"]


def test_the_thresholds_are_side_by_side() -> None:
    first = experiment({"0.000625": GROWING[:1]}, seeds=2)
    last = experiment({"0.04": GROWING[3:]})
    first = judged(first, HELD_OUT, {"share_unsafe": 0.417})
    thresholds = Tables.joined([last, first])
    found = section(
        report(experiment({"safedagger": GROWING}), thresholds=thresholds), "Other thresholds"
    )
    strict, lax = found.strip().splitlines()[-2:]
    assert strict.startswith("| 0.000625 | 0, 1 | 41.7 % | 3.00 / 3.00")
    assert "| 8.0 % / 20.0 % |" in strict
    assert lax.startswith("| 0.04 | 0 | - | 3.00")
    assert "| 2.0 % / 5.0 % |" in lax


def test_which_errors_are_safe_by_seed() -> None:
    errors = {
        1: {"tau": 0.01, "trained_on": {"share_safe": 0.99}, "held_out": {"share_safe": 0.9}},
        0: {
            "tau": 0.0025,
            "share": 0.777,
            "trained_on": {"share_safe": 0.961},
            "held_out": {"share_safe": 0.8425, "tau_for_share": 0.00168123},
        },
    }
    shares = {seed: ErrorShares.model_validate(each) for seed, each in errors.items()}
    text = report(experiment({"safedagger": GROWING}, seeds=2), errors=shares)
    found = section(text, "Which errors are safe").strip().splitlines()
    assert found[-2:] == [
        "| 0 | 0.0025 | 96.1 % | 84.2 % | 0.00168 (77.7 %) |",
        "| 1 | 0.01 | 99.0 % | 90.0 % | - |",
    ]
    assert "- Seed 1: no tau for the paper's share of safe frames in errors.json." in text


def test_track_by_track_after_the_last_iteration_over_all_seeds() -> None:
    slow = {"laps": lambda drives: 1.0 + drives.seed, "damage": 3.0}
    made_up = experiment({"dagger": SLOW[:2], "safedagger": [*GROWING, FULL]}, seeds=2)
    made_up = redriven(made_up, slow, scenario="yew", condition="traffic")
    text = section(report(made_up), "Track by track, after the last iteration")
    found = rows(text, "Takeover, safe")
    assert list(found) == [
        (run, track) for run in ("SafeDAgger", "DAgger") for track in ("spruce", "willow", "yew")
    ]
    assert found["DAgger", "spruce"] == ["2.10 / 1.60", "3.00 / 3.00", "0 / 0", "7.5 % / 19.0 %"]
    assert found["SafeDAgger", "yew"] == ["3.00 / 1.50", "3.00 / 1.50", "0 / 2", "2.0 % / 5.0 %"]


def test_a_track_without_drives_of_a_strategy_has_no_number() -> None:
    text = report(undriven(experiment({"safedagger": [FULL]}), scenario="yew", strategy="safe"))
    found = rows(section(text, "Track by track, after the last iteration"), "Takeover, safe")
    assert found["SafeDAgger", "yew"] == ["3.00 / 3.00", "- / -", "0 / 0", "- / -"]


def _alone(share: float, made_up: Experiment) -> Experiment:
    """SafeDAgger's primaries alone, before and after the loop of seed 0; the last does a share of the laps."""
    run = {"run": {"safedagger500": "safedagger"}}
    found = curves({"safedagger500": share})
    return replace(
        found,
        drives=found.drives.replace(run),
        ledgers=found.ledgers.replace(run),
        specs=made_up.specs,
    )
