"""The head of the report says how the claims stand, and compares laps and what they cost."""

from dataclasses import replace

from tests.evaluation.made_up import (
    FULL,
    GOOD,
    GROWING,
    SLOW,
    ending,
    experiment,
    redriven,
    without,
)
from tests.report.rendered import report


def test_the_first_screen_compares_laps_and_queries() -> None:
    title, _, headline, picture, cost, basis, *_ = report(experiment(GOOD)).split("\n\n")
    assert title.startswith("# ")
    *lines, supervised = headline.splitlines()
    assert lines == [
        "- After supervised training alone, the primary, driven naively, completes 2.00 of 3 "
        "laps without traffic and 1.50 with traffic.",
        "- After iteration 3 of SafeDAgger, at 7,000 queries, it completes 3.00 and 3.00. All "
        "24 naive drives did 3 laps first after iteration 3, at 7,000 queries. With the safe "
        "strategy it completes 3.00 and 3.00, the reference driving 2.0 % and 5.0 % of the "
        "time; before the loop it was 8.0 % and 20.0 %.",
        "- After iteration 3 of DAgger, at 35,000 queries, it completes 2.40 and 2.10. After no "
        "iteration did all naive drives do 3 laps. SafeDAgger asked 5.0 times fewer queries in "
        "the loop; with D_0, and D_safe that only it needs, 2.4 times fewer labels (15,600 "
        "against 38,000).",
        "- After iteration 3 of DAgger, SafeDAgger's queries, at 9,000 queries, it completes "
        "2.40 and 2.10. After no iteration did all naive drives do 3 laps. SafeDAgger asked 1.3 "
        "times fewer queries in the loop; with D_0, and D_safe that only it needs, 1.3 times as "
        "many labels (15,600 against 12,000).",
    ]
    assert supervised == lines[2].replace("of DAgger,", "of supervised,")
    assert picture.endswith("(figures/result.png)")
    assert cost.startswith("**Cost.**")
    assert basis.startswith("**Basis.**")


def test_the_first_screen_follows_the_data() -> None:
    dear = [replace(level, queries=14_000) for level in GROWING]
    made_up = experiment(
        {
            "safedagger": ending(dear, laps=(1.0, 0.5)),
            "dagger": SLOW[:2],
            "supervised": ending(dear, laps=(2.0, 0.5)),
        },
        seeds=2,
    )
    partly = without(made_up, seed=0, run="dagger")
    headline = report(partly).split("\n\n")[2]
    assert "of SafeDAgger, at 42,000 queries, it completes 1.00 and 0.50" in headline
    assert "After iteration 1 of DAgger on seed 1, at 15,000 queries, it completes" in headline
    assert "SafeDAgger asked 2.8 times as many queries in the loop; with" in headline
    assert "SafeDAgger asked as many queries in the loop; with" in headline
    others = report(experiment({"safedagger_max": GROWING})).split("\n\n")[2]
    assert others == "There are no results of any training strategy."


def test_the_first_line_counts_the_verdicts() -> None:
    mixed = experiment({**GOOD, "safedagger_last": SLOW[:2], "safedagger_rising": SLOW[:3]})
    assert report(mixed).split("\n\n")[1] == (
        "Of the 19 [claims of the paper](#claims-of-the-paper), 15 hold (1, 2, 3, 4, 5, 6, 8, 9, 11, "
        "12, 13, 16, 17, 18, 19), 0 do not hold, 4 are undecided (7, 10, 14, 15)."
    )
    failed = experiment({"safedagger": ending(GROWING, laps=(2.0, 3.0))})
    assert report(failed).split("\n\n")[1] == (
        "Of the 5 [claims of the paper](#claims-of-the-paper), 4 hold (1, 2, 4, 5), 1 does not hold (3), "
        "0 are undecided."
    )


def test_when_all_laps_were_first_done_and_lost_again() -> None:
    """A single drive of one seed is enough to lose them."""
    levels = [FULL, GROWING[0], FULL, FULL]
    made_up = experiment({"safedagger": [GROWING[0], *levels]}, seeds=2)
    one = {"scenario": "yew", "start": 0, "strategy": "naive", "condition": "traffic"}
    lost = redriven(made_up, {"laps": 2.99}, seed=1, iteration=4, **one)
    assert (
        "All 48 naive drives did 3 laps first after iteration 1, at 1,000 queries, but no longer "
        "after iteration 2 and 4." in report(lost)
    )


def test_runs_that_share_no_seed_have_no_factor() -> None:
    made_up = experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)
    apart = without(without(made_up, seed=1, run="safedagger"), seed=0, run="dagger")
    headline = report(apart).split("\n\n")[2]
    assert "of SafeDAgger on seed 0" in headline and "of DAgger on seed 1" in headline
    assert "times" not in headline
