"""What went wrong while each strategy collected, by counts of which the answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import poisson

from pipeline.claims.collecting import fails_less_often, is_unharmed
from pipeline.claims.findings import Finding
from pipeline.claims.verdicts import claims
from tests.evaluation.made_up import GOOD, GROWING, SLOW, Level, Table, experiment, reckoned

UNCOUNTED = "not measured: its ledgers do not count failures"


def failing(levels: list[Level], *failures: int) -> list[Level]:
    """With so many in iterations 1, 2, ..., of 1,000 frames each; what iteration 0 has is not the loop's."""
    first, *loop = levels
    counts = zip(loop, failures, strict=True)
    return [replace(first, failures=99), *(replace(each, failures=n) for each, n in counts)]


def compared(ours: tuple[int, ...], theirs: tuple[int, ...], seeds: int = 1) -> Finding:
    table = {"safedagger": failing(GROWING, *ours), "dagger": failing(SLOW, *theirs)}
    return fails_less_often(experiment(table, seeds=seeds, starts=1), "safedagger", "dagger")


def test_each_strategy_has_a_verdict_of_its_own() -> None:
    """SafeDAgger against each DAgger that collects as it does, then one by one."""
    table: Table = {**GOOD, "dagger": failing(SLOW, 9, 8, 7)}
    made_up = experiment(table, starts=1)
    found = {each.words: each(made_up).verdict for each in claims(made_up)[13:]}
    less = (
        "While collecting, SafeDAgger leaves the road, touches a car or stands still less often, "
    )
    without = " learns without any catastrophic experience: while it collects, no drive leaves the "
    assert found == {
        f"{less}frame by frame, than DAgger.": "holds",
        f"{less}frame by frame, than DAgger, SafeDAgger's queries.": "undecided",
        f"SafeDAgger{without}road, touches a car or stands still.": "holds",
        f"DAgger{without}road, touches a car or stands still.": "does not hold",
        f"DAgger, SafeDAgger's queries{without}road, touches a car or stands still.": "holds",
        f"supervised{without}road, touches a car or stands still.": "holds",
    }


def test_another_way_to_begin_and_end_drives_is_not_compared() -> None:
    made_up = experiment(GOOD, starts=1)
    specs = {
        **made_up.specs,
        "dagger": made_up.specs["dagger"].model_copy(update={"protocol": "x"}),
    }
    told = [each.words for each in claims(replace(made_up, specs=specs))]
    (less,) = (words for words in told if "less often" in words)
    assert less.endswith("than DAgger, SafeDAgger's queries.")


def test_no_failure_holds_with_what_it_leaves_possible() -> None:
    found = is_unharmed(experiment({"safedagger": failing(GROWING, 0, 0, 0)}), "safedagger")
    assert found == Finding(
        True,
        "0 failures in 3,000 frames of 12 drives (seed 0), 1 in 1,000 frames at most (upper 95 % bound)",
        "0 failures in 3,000 frames of 12 drives (seed 0), 1 in 1,000 frames at most (upper 95 % bound) "
        "(road left 0, touches 0, stood still 0; put back 0)",
    )


def test_a_failure_on_one_seed_is_one_too_many() -> None:
    made_up = experiment({"safedagger": failing(GROWING, 0, 0, 0)}, seeds=2)
    once = {"failures": 1, "failures.road_left": 1, "put_back": 1}
    found = is_unharmed(reckoned(made_up, once, seed=1, iteration=2), "safedagger")
    assert found.holds is False
    assert found.evidence.startswith(
        "1 failure in 6,000 frames of 24 drives (seeds 0, 1), 0.79 in 1,000"
    )
    assert found.evidence.endswith("(road left 1, touches 0, stood still 0; put back 1)")


@pytest.mark.parametrize("failures", [0, 1, 5, 20])
def test_the_bound_is_the_rate_at_which_so_few_are_rare(failures: int) -> None:
    made_up = experiment({"safedagger": failing(GROWING, failures, 0, 0)}, starts=1)
    words = is_unharmed(made_up, "safedagger").observed
    rate = float(words.split(", ")[-1].split(" in ")[0])
    assert poisson.cdf(failures, rate * 3) == pytest.approx(0.05, abs=0.02)


def test_on_one_seed_the_share_of_failures_is_set_against_that_of_frames() -> None:
    found = compared((0, 1, 0), (5, 6, 8))
    assert found.holds is True
    assert (
        found.observed
        == "1 of 20 failures [0.1 %, 24.9 %] in 50.0 % of the frames of both (seed 0)"
    )
    assert found.evidence.startswith(
        "SafeDAgger: 1 failure in 3,000 frames of 12 drives (seed 0), "
    )
    assert "; DAgger: 19 failures in 3,000 frames of 12 drives (seed 0), " in found.evidence
    assert compared((5, 6, 8), (0, 1, 0)).holds is False
    assert compared((0, 1, 0), (1, 1, 1)).holds is None


def test_frames_driven_are_what_counts() -> None:
    """As many failures in a tenth of the frames are ten times as often."""
    table: Table = {"safedagger": failing(GROWING, 3, 3, 3), "dagger": failing(SLOW, 3, 3, 3)}
    made_up = experiment(table)
    assert fails_less_often(made_up, "safedagger", "dagger").holds is None
    further = reckoned(made_up, {"frames_driven": 10_000}, run="safedagger")
    assert fails_less_often(further, "safedagger", "dagger").holds is True


def test_on_several_seeds_by_seed_and_iteration() -> None:
    found = compared((0, 1, 0), (5, 6, 8), seeds=2)
    assert found.holds is True
    assert found.observed.startswith("0.333 against 6.33 in 1,000 frames (-6 [")
    assert found.observed.endswith(", 6 pairs) (seeds 0, 1)")
    assert compared((5, 6, 8), (0, 1, 0), seeds=2).holds is False
    assert compared((0, 9, 0), (5, 0, 8), seeds=2).holds is None


def test_where_nothing_failed_nothing_is_less() -> None:
    for seeds, words in ((1, "seed 0"), (2, "seeds 0, 1")):
        found = compared((0, 0, 0), (0, 0, 0), seeds=seeds)
        assert (found.holds, found.observed) == (None, f"no failure in either ({words})")


OLDER = {"failures": np.nan, "put_back": np.nan, "failures.touches": np.nan}


def test_ledgers_that_do_not_count_failures_leave_it_open() -> None:
    made_up = experiment(GOOD, starts=1)
    older = reckoned(made_up, OLDER, run="dagger", iteration=2)
    assert is_unharmed(older, "dagger") == Finding(None, UNCOUNTED, UNCOUNTED)
    assert is_unharmed(older, "safedagger").holds is True
    assert fails_less_often(older, "safedagger", "dagger").observed == UNCOUNTED
    assert fails_less_often(older, "dagger", "safedagger").observed == UNCOUNTED


def test_a_seed_that_counts_failures_is_judged_without_one_that_does_not() -> None:
    """Such as one that was run before they were counted; of two runs, where both count them."""
    table: Table = {
        "safedagger": failing(GROWING, 0, 1, 0),
        "dagger": failing(SLOW, 5, 6, 8),
    }
    three = experiment(table, seeds=3, starts=1)
    older = reckoned(three, OLDER, run="dagger", iteration=2, seed=2)
    unharmed = is_unharmed(older, "dagger")
    assert unharmed.observed.startswith("38 failures in 6,000 frames of 24 drives (seeds 0, 1), ")
    assert " (seeds 0, 1, 2), " in is_unharmed(older, "safedagger").observed
    two = fails_less_often(experiment(table, seeds=2, starts=1), "safedagger", "dagger")
    assert fails_less_often(older, "safedagger", "dagger") == two
    both = reckoned(older, OLDER, run="safedagger", iteration=1, seed=0)
    alone = fails_less_often(both, "safedagger", "dagger")
    assert (
        alone.observed
        == "1 of 20 failures [0.1 %, 24.9 %] in 50.0 % of the frames of both (seed 1)"
    )
