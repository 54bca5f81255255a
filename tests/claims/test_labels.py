"""How many labels it takes: each answer can be yes, no and open, on made-up drives."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.claims.labels import MARGIN, against, answers, is_as_reliable
from pipeline.evaluation.comparison import Contrast
from pipeline.evaluation.statistics import Estimate
from tests.evaluation.made_up_curves import SPECS, curves

BEST = {"dagger4000": 0.9}
HALF = "{}: as reliable as DAgger, 4,000 labels, on at most half of its labels in the loop."
MORE = "{}: more reliable than {}."
IDLE = "more training, no labels"
OURS, THEIRS = (f"{name}, 2,000 labels" for name in ("SafeDAgger", "DAgger"))

ends = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(sorted)


@given(ends, st.floats(0, 1), st.floats(0, 1))
def test_a_wider_margin_turns_no_yes_into_a_no(
    interval: list[float], margin: float, more: float
) -> None:
    low, value, high = interval
    found = Contrast(value, 0.0, Estimate(value, low, high, 40))
    before, after = (is_as_reliable(found, each) for each in (margin, margin + more))
    order = [False, None, True]
    assert order.index(before) <= order.index(after)


@pytest.mark.parametrize(
    ("low", "high", "holds"),
    [(-0.04, 0.1, True), (-0.06, 0.1, None), (-0.06, -0.04, None), (-0.2, -0.06, False)],
)
def test_as_reliable_is_by_the_whole_interval(low: float, high: float, holds: bool | None) -> None:
    assert math.isclose(MARGIN, 0.05)
    assert is_as_reliable(Contrast(0, 0, Estimate((low + high) / 2, low, high, 40))) is holds


@pytest.mark.parametrize(
    ("claim", "share", "verdict"),
    [
        (HALF.format(OURS), {"safedagger2000": 0.9, **BEST}, "holds"),
        (HALF.format(OURS), {"safedagger2000": 0.85, **BEST}, "undecided"),
        (HALF.format(OURS), {"safedagger2000": 0.6, **BEST}, "does not hold"),
        (MORE.format(OURS, THEIRS), {"safedagger2000": 0.9, "dagger2000": 0.7}, "holds"),
        (MORE.format(OURS, THEIRS), {"safedagger2000": 0.9, "dagger2000": 0.875}, "undecided"),
        (MORE.format(OURS, THEIRS), {"safedagger2000": 0.9, "dagger2000": 0.9}, "does not hold"),
        (MORE.format(THEIRS, IDLE), {"dagger2000": 0.9, "training": 0.5}, "holds"),
        (MORE.format(THEIRS, IDLE), {"dagger2000": 0.9, "training": 0.875}, "undecided"),
        (MORE.format(THEIRS, IDLE), {"dagger2000": 0.4, "training": 0.5}, "does not hold"),
    ],
)
def test_every_claim_can_come_out_three_ways(
    claim: str, share: dict[str, float], verdict: str
) -> None:
    judged = {each.claim: each.verdict for each in answers(curves(share))}
    assert judged[claim] == verdict


def test_a_verdict_says_on_how_many_drives_and_seeds_it_rests() -> None:
    found = against(curves({"safedagger500": 0.9, **BEST}, seeds=2), "safedagger500", "dagger4000")
    assert found.holds
    assert found.evidence == (
        "success: 90.0 % against 90.0 % (+0.0 [+0.0, +0.0], 80 pairs); 160 drives of each, seeds 0, 1"
    )


def test_fewer_than_40_tracks_and_runs_that_have_not_ended_decide_nothing() -> None:
    few = curves({"safedagger500": 1.0, "dagger4000": 1.0}, tracks=39)
    assert against(few, "safedagger500", "dagger4000").holds is None
    alone = curves({"safedagger2000": 1.0})
    assert against(alone, "safedagger2000", "dagger4000").holds is None
    assert {each.verdict for each in answers(alone)} == {"undecided"}
    assert answers(curves({})) == []


def test_there_is_a_claim_for_each_budget_and_way_to_collect() -> None:
    def named(*names: str) -> list[str]:
        return [SPECS[name].name for name in names]

    judged = answers(curves(dict.fromkeys(SPECS, 0.9)))
    assert [each.verdict for each in judged] == ["holds"] * 8 + ["does not hold"] * 39
    ways = "sized", "seldom", "quarter", "audited", "aside"
    seldom = "dagger_seldom2000"
    halves = named("safedagger2000", "dagger2000", seldom, *(f"{way}2000" for way in ways))
    ours = "safedagger500", "safedagger1000", "safedagger2000", "safedagger1000_anywhere"
    theirs = "dagger500", "dagger1000", "dagger2000", "dagger1000_anywhere"
    others = [name for way in ways for name in SPECS if name.startswith(way)]
    equals = [re.sub("^[a-z]+", "dagger", name) for name in others]
    rivals = [
        named(run, rival)
        for run, equal in zip([*ours, *others], [*theirs, *equals], strict=True)
        for rival in ([equal, seldom] if equal == "dagger2000" else [equal])
    ]
    plain = zip(named(*others), named(*(f"safe{name}" for name in equals)), strict=True)
    most = ("safedagger2000", "dagger4000", seldom, "supervised2000", ours[3], theirs[3])
    assert [each.claim for each in judged] == [
        *(HALF.format(run) for run in halves),
        *(MORE.format(run, rival) for run, rival in [*rivals, *plain]),
        *(MORE.format(run, IDLE) for run in [*named(*most), *halves[3:]]),
    ]
