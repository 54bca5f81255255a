"""Each claim can hold, not hold and be undecided, on made-up data of which the answer is known."""

from dataclasses import replace

import pytest

from pipeline.claims.verdicts import Verdict, claims, verdicts
from pipeline.evaluation.experiment import Experiment, Tables
from tests.evaluation.made_up import (
    FIRST,
    GOOD,
    GROWING,
    NOTHING,
    SLOW,
    Level,
    Table,
    ending,
    experiment,
    scattered,
    undriven,
    without,
)

NAMES = (
    "supervised_fails",
    "safe_drives_as_far",
    "shows_the_trend",
    "reaches_three_laps_first",
    "error_falls_faster",
    "takeover_falls_faster",
    "fixed_tau_is_enough",
    "supervised_stays_behind",
    "takeover_is_larger_in_traffic",
    "last_shows_the_trend",
    "max_shows_the_trend",
    "fewer_queries_than_dagger",
    "fewer_queries_than_dagger_budget",
)
"""Of the claims, in the order of the report; how it collected is judged in test_collecting."""
NAMED = dict(zip(NAMES, claims(experiment(GOOD)), strict=False))


def judged(name: str, made_up: Experiment) -> Verdict:
    return NAMED[name](made_up)


def test_every_claim_can_hold() -> None:
    found = verdicts(experiment(GOOD))[: len(NAMES)]
    assert [each.claim for each in found] == [NAMED[name].words for name in NAMES]
    assert len({each.claim for each in found}) == len(NAMES)
    assert {each.verdict for each in found} == {"holds"}


def test_only_claims_whose_runs_there_are_have_a_verdict() -> None:
    *alone, last = verdicts(experiment({"safedagger": GROWING}))
    assert last.claim.startswith("SafeDAgger learns without")
    names = (*NAMES[:3], "takeover_is_larger_in_traffic")
    assert [each.claim for each in alone] == [NAMED[name].words for name in names]
    assert {each.verdict for each in alone} == {"holds"}
    added = verdicts(experiment({"safedagger": GROWING, "safedagger_max": GROWING}))
    assert NAMED["max_shows_the_trend"].words in [each.claim for each in added]
    assert len(added) == len(alone) + 2


NEVER, OPEN = "does not hold", "undecided"
SAME_LAPS = "without traffic, laps of naive, iteration 3 against 0: 2.00 against 2.00 (+0.00 ["
SAME_TAKEOVER = (
    "with traffic, takeover of safe, iteration 3 against 0: 20.0 % against 20.0 % (+0.0 [-"
)
NO_TREND = ending(GROWING, takeover=(0.08, 0.2), scatter=0.5)
PERFECT = Level(laps=(3.0, 3.0))
ALIKE = Level(takeover=(0.1, 0.1))


@pytest.mark.parametrize(
    ("claim", "changes", "verdict", "evidence"),
    [
        (
            *("supervised_fails", {run: [PERFECT, *of[1:]] for run, of in GOOD.items()}, NEVER),
            "seed 0: in 0 of 6 cases of track and traffic; worst is spruce without traffic, 3.00 of 3",
        ),
        (
            *("safe_drives_as_far", {"safedagger_max": ending(GROWING, safe_laps=(3, 1))}, NEVER),
            "surely in 43 of 44 cells; SafeDAgger, 1 s ahead (max), iteration 3, with traffic: "
            "1.00 against 3.00 (-2.00 [-2.00, -2.00], 12 pairs)",
        ),
        (
            *(
                "safe_drives_as_far",
                {"dagger": scattered([replace(FIRST, safe_laps=(2, 3))])},
                OPEN,
            ),
            "DAgger, iteration 0, without traffic: 2.00 against 2.00 (+0.00 [-",
        ),
        (
            *("shows_the_trend", {"safedagger": ending(GROWING, laps=(2.0, 3.0))}, NEVER),
            f"{SAME_LAPS}+0.00",
        ),
        ("shows_the_trend", {"safedagger": NO_TREND}, OPEN, SAME_TAKEOVER),
        (
            *("last_shows_the_trend", {"safedagger_last": ending(GROWING, laps=(2, 3))}, NEVER),
            f"{SAME_LAPS}+0.00",
        ),
        (
            "last_shows_the_trend",
            *({"safedagger_last": ending(GROWING, laps=(2.0, 1.5), scatter=0.5)}, OPEN),
            f"{SAME_LAPS}-",
        ),
        (
            *("max_shows_the_trend", {"safedagger_max": ending(GROWING, takeover=(0, 0.3))}, NEVER),
            "with traffic, takeover of safe, iteration 3 against 0: 30.0 % against 20.0 % (+10.0 [",
        ),
        ("max_shows_the_trend", {"safedagger_max": NO_TREND}, OPEN, SAME_TAKEOVER),
        (
            *("reaches_three_laps_first", {"safedagger": ending(GROWING, laps=(3, 2.99))}, NEVER),
            "seed 0: SafeDAgger never, DAgger never",
        ),
        (
            *("reaches_three_laps_first", {"dagger": GROWING}, NEVER),
            "seed 0: SafeDAgger after iteration 3, DAgger after iteration 3",
        ),
        (
            *("error_falls_faster", {"dagger": GROWING}, NEVER),
            "without traffic, iterations 1 to 3 against DAgger's: 0.00767 against 0.00767 (+0",
        ),
        (
            *("error_falls_faster", {"safedagger": ending(GROWING, error=(0.005, 0.04))}, NEVER),
            "with traffic, iteration 3 against 0: 0.04 against 0.03 (+0.01 [+0.01, +0.01], 12 pairs)",
        ),
        ("error_falls_faster", {"dagger": scattered(GROWING)}, OPEN, "iterations 1 to 3 against"),
        (
            *("takeover_falls_faster", {"safedagger": SLOW, "dagger": GROWING}, NEVER),
            "with traffic, iterations 1 to 3 against DAgger's: 18.3 % against 10.0 % (+8.3 [+8.3",
        ),
        (
            "takeover_falls_faster",
            {"dagger": scattered(GROWING)},
            OPEN,
            "iterations 1 to 3 against",
        ),
        (
            *("fixed_tau_is_enough", {"safedagger": SLOW}, NEVER),
            "SafeDAgger, rising tau against SafeDAgger, iteration 3: 3.00 against 2.25 (+0.75 [+0.75",
        ),
        (
            "fixed_tau_is_enough",
            *({"safedagger_rising": scattered(SLOW), "safedagger": SLOW}, OPEN),
            "2.25 against 2.25",
        ),
        (
            *("supervised_stays_behind", {"supervised": ending(GROWING, laps=(3, 2.9))}, NEVER),
            "SafeDAgger against supervised, iteration 3: 3.00 against 2.95 (+0.05 [+0.05, +0.05]",
        ),
        ("supervised_stays_behind", {"safedagger": scattered(SLOW)}, OPEN, "against 2.25 ("),
        (
            *("takeover_is_larger_in_traffic", {"safedagger": [ALIKE]}, NEVER),
            "with traffic against without: 10.0 % against 10.0 % (+0.0 [+0.0, +0.0], 12 pairs)",
        ),
        (
            *("takeover_is_larger_in_traffic", {"safedagger": scattered([ALIKE])}, OPEN),
            "10.0 % against 10.0 % (+0.0 [-",
        ),
        (
            "fewer_queries_than_dagger",
            *({"safedagger": SLOW, "dagger": ending(GROWING, queries=50_000)}, NEVER),
            "DAgger at its best: 3.00 laps after 56,000 queries; "
            "SafeDAgger as far, within 0.1: surely never, possibly never",
        ),
        (
            *("fewer_queries_than_dagger", {"safedagger": scattered(SLOW)}, OPEN),
            "DAgger at its best: 2.25 laps after 35,000 queries; "
            "SafeDAgger as far, within 0.1: surely never, possibly after 30,000 (factor 1.2)",
        ),
        (
            *("fewer_queries_than_dagger_budget", {"dagger_budget": GROWING}, NEVER),
            "DAgger, SafeDAgger's queries at its best: 3.00 laps after 7,000 queries; "
            "SafeDAgger as far, within 0.1: surely after 7,000 (factor 1.0)",
        ),
        (
            "fewer_queries_than_dagger_budget",
            *({"dagger_budget": ending(SLOW, queries=10_000), "safedagger": scattered(SLOW)}, OPEN),
            "2.25 laps after 40,000 queries",
        ),
    ],
)
def test_every_claim_can_fail_or_stay_open(
    claim: str, changes: Table, verdict: str, evidence: str
) -> None:
    found = judged(claim, experiment({**GOOD, **changes}))
    assert evidence in found.evidence
    assert found.verdict == verdict


@pytest.mark.parametrize(
    ("claim", "runs"),
    [
        ("shows_the_trend", "SafeDAgger"),
        ("reaches_three_laps_first", "SafeDAgger and DAgger"),
        ("error_falls_faster", "SafeDAgger and DAgger"),
        ("takeover_falls_faster", "SafeDAgger and DAgger"),
        ("fixed_tau_is_enough", "SafeDAgger and SafeDAgger, rising tau"),
        ("supervised_stays_behind", "SafeDAgger and supervised"),
        ("last_shows_the_trend", "SafeDAgger, 1 s ahead (last)"),
        ("max_shows_the_trend", "SafeDAgger, 1 s ahead (max)"),
        ("fewer_queries_than_dagger", "SafeDAgger and DAgger"),
        ("fewer_queries_than_dagger_budget", "SafeDAgger and DAgger, SafeDAgger's queries"),
    ],
)
def test_without_the_whole_loop_it_is_undecided(claim: str, runs: str) -> None:
    cut_short = {run: levels[:-1] for run, levels in GOOD.items()}
    found = judged(claim, experiment(cut_short))
    assert found.evidence == f"no seed has iterations 0 to 3 of {runs}"
    assert found.verdict == OPEN


def test_what_needs_no_loop_needs_its_drives() -> None:
    found = judged("takeover_is_larger_in_traffic", experiment({"dagger": SLOW}))
    assert found.verdict == OPEN
    assert found.evidence == "with traffic against without: not measured"
    assert judged("safe_drives_as_far", experiment({"dagger": SLOW[:2]})).verdict == "holds"
    assert judged("safe_drives_as_far", NOTHING).verdict == OPEN


def good_and_bad() -> Experiment:
    """Seed 0 and seed 1."""
    good, bad = experiment(GOOD, seeds=2), experiment({**GOOD, "safedagger": SLOW}, seeds=2)
    tables = Tables.joined([without(good, seed=1), without(bad, seed=0)])
    return Experiment(**vars(tables), specs=good.specs)


def test_seeds_that_disagree_leave_it_open() -> None:
    found = judged("reaches_three_laps_first", good_and_bad())
    assert found.verdict == OPEN
    assert found.evidence.startswith(
        "seed 0: SafeDAgger after iteration 3, DAgger never; seed 1: SafeDAgger never"
    )


def test_seeds_without_the_whole_loop_do_not_count() -> None:
    """The second seed has no drives of safe in traffic, and would change the verdict."""
    cell = {"run": "safedagger", "iteration": 2, "strategy": "safe", "condition": "traffic"}
    found = judged("supervised_stays_behind", undriven(good_and_bad(), seed=1, **cell))
    assert found == judged("supervised_stays_behind", experiment(GOOD))


def test_three_drives_prove_nothing() -> None:
    """One start on each track, on one seed; on two seeds, six pairs that agree do. Only what looks
    at every single drive needs no pairs.
    """
    few, more = (
        verdicts(experiment(GOOD, seeds=seeds, starts=1))[: len(NAMES)] for seeds in (1, 2)
    )
    decided = [name for name, each in zip(NAMES, few, strict=True) if each.verdict != OPEN]
    assert decided == ["supervised_fails", "reaches_three_laps_first"]
    assert "3 pairs: too few" in few[1].evidence
    assert few[-1].evidence == "fewer than 6 starts that both were given"
    assert {each.verdict for each in more} == {"holds"}
