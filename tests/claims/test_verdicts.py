"""Each claim can hold, not hold and be undecided, on made-up data of which the answer is known."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from pipeline.claims.verdicts import Claim, verdicts
from pipeline.claims.verdicts import claims as all_claims
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
    redriven,
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
NAMED = dict(zip(NAMES, all_claims(experiment(GOOD)), strict=False))
claims = SimpleNamespace(**NAMED)


def named(claim: Claim) -> str:
    return next(name for name, each in NAMED.items() if each.words == claim.words)


def test_every_claim_can_hold() -> None:
    judged = verdicts(experiment(GOOD))[: len(NAMES)]
    assert {(each.claim, each.verdict) for each in judged} == {
        (each.claim, "holds") for each in judged
    }
    assert len({each.claim for each in judged}) == len(judged) == 13


def test_only_claims_whose_runs_there_are_have_a_verdict() -> None:
    *alone, last = verdicts(experiment({"safedagger": GROWING}))
    assert last.claim.startswith("SafeDAgger learns without")
    assert [each.claim for each in alone] == [
        claim.words
        for claim in (
            claims.supervised_fails,
            claims.safe_drives_as_far,
            claims.shows_the_trend,
            claims.takeover_is_larger_in_traffic,
        )
    ]
    assert {each.verdict for each in alone} == {"holds"}
    added = verdicts(experiment({"safedagger": GROWING, "safedagger_max": GROWING}))
    assert claims.max_shows_the_trend.words in [each.claim for each in added]
    assert len(added) == len(alone) + 2


def test_of_many_cells_the_worst_are_named_first() -> None:
    """Three pairs decide nothing; a run that drives worse when safe is among what decides."""
    few = experiment({"safedagger": GROWING}, starts=1)
    evidence = claims.safe_drives_as_far(few).evidence
    assert evidence.startswith("surely in 0 of 8 cells; SafeDAgger, iteration 0, without traffic")
    assert evidence.endswith("; and 5 more")
    worse = [replace(level, safe_laps=(3.0, 0.5)) for level in scattered(GROWING)]
    evidence = claims.safe_drives_as_far(experiment({"safedagger": worse})).evidence
    assert "0.50 against" in evidence.split("; ")[1]


PERFECT = Level(laps=(3.0, 3.0))
UNSURE = {"takeover": (0.02, 0.2), "scatter": 0.5}
DOES_NOT_HOLD: list[tuple[Claim, Table, str]] = [
    (
        claims.supervised_fails,
        {run: [PERFECT, *levels[1:]] for run, levels in GOOD.items()},
        "seed 0: in 0 of 6 cases of track and traffic; worst is spruce without traffic, 3.00 of 3",
    ),
    (
        claims.shows_the_trend,
        {"safedagger": ending(GROWING, laps=(2.0, 3.0))},
        "without traffic, laps of naive, iteration 3 against 0: 2.00 against 2.00 (+0.00 [+0.00",
    ),
    (
        claims.safe_drives_as_far,
        {"safedagger_max": ending(GROWING, safe_laps=(3.0, 1.0))},
        "surely in 55 of 56 cells; SafeDAgger, 1 s ahead (max), iteration 3, with traffic: "
        "1.00 against 3.00 (-2.00 [-2.00, -2.00], 12 pairs)",
    ),
    (
        claims.reaches_three_laps_first,
        {"safedagger": ending(GROWING, laps=(3.0, 2.99))},
        "seed 0: SafeDAgger never, DAgger never",
    ),
    (
        claims.reaches_three_laps_first,
        {"dagger": GROWING},
        "seed 0: SafeDAgger after iteration 3, DAgger after iteration 3",
    ),
    (
        claims.error_falls_faster,
        {"dagger": GROWING},
        "without traffic, iterations 1 to 3 against DAgger's: 0.00767 against 0.00767 (+0",
    ),
    (
        claims.error_falls_faster,
        {"safedagger": ending(GROWING, error=(0.005, 0.04))},
        "with traffic, iteration 3 against 0: 0.04 against 0.03 (+0.01 [+0.01, +0.01], 12 pairs)",
    ),
    (
        claims.takeover_falls_faster,
        {"safedagger": SLOW, "dagger": GROWING},
        "with traffic, iterations 1 to 3 against DAgger's: 18.3 % against 10.0 % (+8.3 [+8.3",
    ),
    (
        claims.fixed_tau_is_enough,
        {"safedagger": SLOW},
        "SafeDAgger, rising tau against SafeDAgger, iteration 3: 3.00 against 2.25 (+0.75 [+0.75",
    ),
    (
        claims.supervised_stays_behind,
        {"supervised": ending(GROWING, laps=(3.0, 2.9))},
        "SafeDAgger against supervised, iteration 3: 3.00 against 2.95 (+0.05 [+0.05, +0.05]",
    ),
    (
        claims.takeover_is_larger_in_traffic,
        {"safedagger": [Level(takeover=(0.1, 0.1))]},
        "with traffic against without: 10.0 % against 10.0 % (+0.0 [+0.0, +0.0], 12 pairs)",
    ),
    (
        claims.last_shows_the_trend,
        {"safedagger_last": ending(GROWING, laps=(2.0, 3.0))},
        "without traffic, laps of naive, iteration 3 against 0: 2.00 against 2.00 (+0.00 [+0.00",
    ),
    (
        claims.max_shows_the_trend,
        {"safedagger_max": ending(GROWING, takeover=(0.01, 0.3))},
        "with traffic, takeover of safe, iteration 3 against 0: 30.0 % against 20.0 % (+10.0 [",
    ),
    (
        claims.fewer_queries_than_dagger,
        {"safedagger": SLOW, "dagger": ending(GROWING, queries=50_000)},
        "DAgger at its best: 3.00 laps after 56,000 queries; "
        "SafeDAgger as far, within 0.1: surely never, possibly never",
    ),
    (
        claims.fewer_queries_than_dagger_budget,
        {"dagger_budget": GROWING},
        "DAgger, SafeDAgger's queries at its best: 3.00 laps after 7,000 queries; "
        "SafeDAgger as far, within 0.1: surely after 7,000 (factor 1.0)",
    ),
]

UNDECIDED: list[tuple[Claim, Table, str]] = [
    (
        claims.shows_the_trend,
        {"safedagger": ending(GROWING, takeover=(0.08, 0.2), scatter=0.5)},
        "with traffic, takeover of safe, iteration 3 against 0: 20.0 % against 20.0 % (+0.0 [-",
    ),
    (
        claims.safe_drives_as_far,
        {"dagger": scattered([replace(FIRST, safe_laps=(2.0, 3.0))])},
        "DAgger, iteration 0, without traffic: 2.00 against 2.00 (+0.00 [-",
    ),
    (claims.error_falls_faster, {"dagger": scattered(GROWING)}, "iterations 1 to 3 against"),
    (claims.takeover_falls_faster, {"dagger": scattered(GROWING)}, "iterations 1 to 3 against"),
    (
        claims.fixed_tau_is_enough,
        {"safedagger_rising": scattered(SLOW), "safedagger": SLOW},
        "2.25 against 2.25",
    ),
    (claims.supervised_stays_behind, {"safedagger": scattered(SLOW)}, "against 2.25 ("),
    (
        claims.takeover_is_larger_in_traffic,
        {"safedagger": scattered([Level(takeover=(0.1, 0.1))])},
        "10.0 % against 10.0 % (+0.0 [-",
    ),
    (
        claims.last_shows_the_trend,
        {"safedagger_last": ending(GROWING, laps=(2.0, 1.5), scatter=0.5)},
        "without traffic, laps of naive, iteration 3 against 0: 2.00 against 2.00 (+0.00 [-",
    ),
    (
        claims.max_shows_the_trend,
        {"safedagger_max": ending(GROWING, takeover=(0.08, 0.2), scatter=0.5)},
        "with traffic, takeover of safe, iteration 3 against 0: 20.0 % against 20.0 % (+0.0 [-",
    ),
    (
        claims.fewer_queries_than_dagger,
        {"safedagger": scattered(SLOW)},
        "DAgger at its best: 2.25 laps after 35,000 queries; "
        "SafeDAgger as far, within 0.1: surely never, possibly after 30,000 (factor 1.2)",
    ),
    (
        claims.fewer_queries_than_dagger_budget,
        {"dagger_budget": ending(SLOW, queries=10_000), "safedagger": scattered(SLOW)},
        "2.25 laps after 40,000 queries",
    ),
]


@pytest.mark.parametrize(
    ("claim", "changes", "evidence", "expected"),
    [(*case, "does not hold") for case in DOES_NOT_HOLD]
    + [(*case, "undecided") for case in UNDECIDED],
    ids=lambda value: named(value) if isinstance(value, Claim) else "",
)
def test_every_claim_can_fail_or_stay_open(
    claim: Claim, changes: Table, evidence: str, expected: str
) -> None:
    judged = claim(experiment({**GOOD, **changes}))
    assert evidence in judged.evidence
    assert judged.verdict == expected


def test_the_yardstick_is_met_on_every_seed_by_its_worst_case() -> None:
    one = {"scenario": "willow", "start": 1, "strategy": "naive", "condition": "no_traffic"}
    first = experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)
    first = redriven(first, {"laps": 0.29}, seed=1, iteration=0, **one)
    judged = claims.supervised_fails(first)
    assert judged.verdict == "holds"
    assert judged.evidence == (
        "seed 0: in 6 of 6 cases of track and traffic; worst is spruce with traffic, 1.50 of 3 "
        "laps; seed 1: in 6 of 6 cases of track and traffic; worst is willow without traffic, 0.29 "
        "of 3 laps"
    )
    mixed = redriven(first, {"laps": 3.0}, seed=0)
    assert claims.supervised_fails(mixed).verdict == "undecided"
    unmeasured = undriven(experiment({"dagger": SLOW[:1]}), strategy="naive")
    assert claims.supervised_fails(unmeasured).evidence == "seed 0: not measured"


def good_and_bad() -> Experiment:
    """Seed 0 and seed 1."""
    good, bad = experiment(GOOD, seeds=2), experiment({**GOOD, "safedagger": SLOW}, seeds=2)
    parts = without(good, seed=1), without(bad, seed=0)
    tables = Tables.joined(parts)
    return Experiment(**vars(tables), specs=good.specs)


def test_seeds_that_disagree_leave_it_open() -> None:
    judged = claims.reaches_three_laps_first(good_and_bad())
    assert judged.verdict == "undecided"
    assert "seed 0: SafeDAgger after iteration 3, DAgger never; seed 1: SafeDAgger never" in (
        judged.evidence
    )


@pytest.mark.parametrize(
    ("claim", "runs"),
    [
        (claims.shows_the_trend, "SafeDAgger"),
        (claims.reaches_three_laps_first, "SafeDAgger and DAgger"),
        (claims.error_falls_faster, "SafeDAgger and DAgger"),
        (claims.takeover_falls_faster, "SafeDAgger and DAgger"),
        (claims.fixed_tau_is_enough, "SafeDAgger and SafeDAgger, rising tau"),
        (claims.supervised_stays_behind, "SafeDAgger and supervised"),
        (claims.last_shows_the_trend, "SafeDAgger, 1 s ahead (last)"),
        (claims.max_shows_the_trend, "SafeDAgger, 1 s ahead (max)"),
        (claims.fewer_queries_than_dagger, "SafeDAgger and DAgger"),
        (claims.fewer_queries_than_dagger_budget, "SafeDAgger and DAgger, SafeDAgger's queries"),
    ],
)
def test_without_the_whole_loop_it_is_undecided(claim: Claim, runs: str) -> None:
    cut_short = {run: levels[:-1] for run, levels in GOOD.items()}
    judged = claim(experiment(cut_short))
    assert judged.evidence == f"no seed has iterations 0 to 3 of {runs}"
    assert judged.verdict == "undecided"


def test_what_needs_no_loop_needs_its_drives() -> None:
    judged = claims.takeover_is_larger_in_traffic(experiment({"dagger": SLOW}))
    assert judged.verdict == "undecided"
    assert judged.evidence == "with traffic against without: not measured"
    assert claims.safe_drives_as_far(experiment({"dagger": SLOW[:2]})).verdict == "holds"
    assert claims.safe_drives_as_far(NOTHING).verdict == "undecided"


def test_seeds_without_the_whole_loop_do_not_count() -> None:
    """The second seed has no drives of safe in traffic, and would change the verdict."""
    cell = {"run": "safedagger", "iteration": 2, "strategy": "safe", "condition": "traffic"}
    judged = claims.supervised_stays_behind(undriven(good_and_bad(), seed=1, **cell))
    assert judged == claims.supervised_stays_behind(experiment(GOOD))


def test_what_is_observed_is_what_decides() -> None:
    """Of several comparisons the first that is as the verdict, with its interval."""

    def observed(claim: Claim, **changes: list[Level]) -> str:
        return claim(experiment({**GOOD, **changes})).observed

    assert observed(claims.shows_the_trend) == (
        "Holds in 4 of 4 comparisons, such as without traffic, laps of naive, iteration 3 against 0: "
        "3.00 against 2.00 (+1.00 [+1.00, +1.00])."
    )
    assert observed(claims.shows_the_trend, safedagger=ending(GROWING, laps=(3.0, 1.0))) == (
        "Holds in 3 of 4 comparisons; does not hold: with traffic, laps of naive, iteration 3 against "
        "0: 1.00 against 1.50 (-0.50 [-0.50, -0.50])."
    )
    open_one = observed(claims.shows_the_trend, safedagger=ending(GROWING, **UNSURE))
    assert open_one.startswith("Holds in 2 of 4 comparisons; undecided: without traffic, laps of ")
    assert observed(claims.supervised_fails) == (
        "Less than 3 laps in 6 of 6 cases of track and traffic (seed 0)."
    )
    first = claims.reaches_three_laps_first
    assert observed(first) == "Within 3 iterations on 1 of 1 seeds, and sooner than DAgger's on 1."
    assert observed(first, dagger=GROWING) == (
        "Within 3 iterations on 1 of 1 seeds, and sooner than DAgger's on 0."
    )
    assert observed(first, safedagger=SLOW) == (
        "Within 3 iterations on 0 of 1 seeds, and sooner than DAgger's on 0."
    )
    assert observed(claims.fewer_queries_than_dagger) == (
        "DAgger: 2.25 laps, its best, after 35,000 queries; SafeDAgger: as far surely after 3,000 "
        "(factor 11.7), possibly after 3,000 (factor 11.7)."
    )


def test_three_drives_prove_nothing() -> None:
    """One start on each track, on one seed; on two seeds, six pairs that agree do. Only what looks
    at every single drive needs no pairs.
    """
    few, more = (
        verdicts(experiment(GOOD, seeds=seeds, starts=1))[: len(NAMES)] for seeds in (1, 2)
    )
    alone = experiment(GOOD, starts=1)
    by_drive = [claims.supervised_fails(alone), claims.reaches_three_laps_first(alone)]
    assert [judged for judged in few if judged.verdict != "undecided"] == by_drive
    assert "3 pairs: too few" in few[1].evidence
    assert few[-1].evidence == "fewer than 6 starts that both were given"
    assert {judged.verdict for judged in more} == {"holds"}
