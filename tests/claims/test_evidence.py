"""What a verdict says for itself: what decides it, and of many numbers the worst first."""

from dataclasses import replace

from tests.claims.test_verdicts import judged
from tests.evaluation.made_up import (
    GOOD,
    GROWING,
    SLOW,
    Level,
    ending,
    experiment,
    redriven,
    scattered,
    undriven,
)

UNSURE = {"takeover": (0.02, 0.2), "scatter": 0.5}


def test_of_many_cells_the_worst_are_named_first() -> None:
    """Three pairs decide nothing; a run that drives worse when safe is among what decides."""
    few = experiment({"safedagger": GROWING}, starts=1)
    evidence = judged("safe_drives_as_far", few).evidence
    assert evidence.startswith("surely in 0 of 8 cells; SafeDAgger, iteration 0, without traffic")
    assert evidence.endswith("; and 5 more")
    worse = [replace(level, safe_laps=(3.0, 0.5)) for level in scattered(GROWING)]
    evidence = judged("safe_drives_as_far", experiment({"safedagger": worse})).evidence
    assert "0.50 against" in evidence.split("; ")[1]


def test_the_yardstick_is_met_on_every_seed_by_its_worst_case() -> None:
    one = {"scenario": "willow", "start": 1, "strategy": "naive", "condition": "no_traffic"}
    first = experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)
    first = redriven(first, {"laps": 0.29}, seed=1, iteration=0, **one)
    found = judged("supervised_fails", first)
    assert found.verdict == "holds"
    all_fail = "in 6 of 6 cases of track and traffic; worst is"
    assert found.evidence == (
        f"seed 0: {all_fail} spruce with traffic, 1.50 of 3 laps; "
        f"seed 1: {all_fail} willow without traffic, 0.29 of 3 laps"
    )
    mixed = redriven(first, {"laps": 3.0}, seed=0)
    assert judged("supervised_fails", mixed).verdict == "undecided"
    unmeasured = undriven(experiment({"dagger": SLOW[:1]}), strategy="naive")
    assert judged("supervised_fails", unmeasured).evidence == "seed 0: not measured"


def test_the_supervised_primary_is_that_of_all_runs_and_none_of_a_part_of_d_0() -> None:
    """A run that sets something of D_0 aside begins with a primary of its own."""
    full = replace(GROWING[0], laps=(3.0, 3.0))
    both = experiment({"safedagger": [full, *GROWING[1:]], "dagger": [GROWING[0], *SLOW[1:]]})
    own = (both.drives.run == "dagger") & (both.drives.iteration == 0)
    both = replace(both, drives=both.drives.assign(step=both.drives.step.mask(own, "dagger_0")))
    assert judged("supervised_fails", both).verdict == "does not hold"


def observed(name: str, **changes: list[Level]) -> str:
    return judged(name, experiment({**GOOD, **changes})).observed


def test_what_is_observed_is_what_decides() -> None:
    """Of several comparisons the first that is as the verdict, with its interval."""
    trend = "shows_the_trend"
    assert observed(trend) == (
        "Holds in 4 of 4 comparisons, such as without traffic, laps of naive, iteration 3 against 0: "
        "3.00 against 2.00 (+1.00 [+1.00, +1.00])."
    )
    assert observed(trend, safedagger=ending(GROWING, laps=(3.0, 1.0))) == (
        "Holds in 3 of 4 comparisons; does not hold: with traffic, laps of naive, iteration 3 against "
        "0: 1.00 against 1.50 (-0.50 [-0.50, -0.50])."
    )
    open_one = observed(trend, safedagger=ending(GROWING, **UNSURE))
    assert open_one.startswith("Holds in 2 of 4 comparisons; undecided: without traffic, laps of ")
    assert observed("supervised_fails") == (
        "Less than 3 laps in 6 of 6 cases of track and traffic (seed 0)."
    )
    assert observed("fewer_queries_than_dagger") == (
        "DAgger: 2.25 laps, its best, after 35,000 queries; SafeDAgger: as far surely after 3,000 "
        "(factor 11.7), possibly after 3,000 (factor 11.7)."
    )


def test_who_does_all_laps_first_is_counted_over_the_seeds() -> None:
    within, sooner = "Within 3 iterations on {} of 1 seeds", ", and sooner than DAgger's on {}."
    first = "reaches_three_laps_first"
    assert observed(first) == within.format(1) + sooner.format(1)
    assert observed(first, dagger=GROWING) == within.format(1) + sooner.format(0)
    assert observed(first, safedagger=SLOW) == within.format(0) + sooner.format(0)
