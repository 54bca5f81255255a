"""What a run should show after Algorithm 1, each checked against the data."""

from dataclasses import dataclass

from pipeline.evaluation.results import Results
from pipeline.evaluation.summary import CONDITIONS, LAPS, measure
from pipeline.evaluation.wording import CONDITION_WORDS, laps, share
from pipeline.policies.strategies import Strategy


@dataclass(frozen=True)
class Check:
    """An expectation, whether it holds, and the numbers that say so."""

    claim: str
    holds: bool
    evidence: str


def check_expectations(results: Results) -> list[Check]:
    """Every expectation, in the order of the report."""
    return [
        _supervised_naive_fails(results),
        _safe_beats_naive(results),
        _naive_gets_further(results),
        _takeover_falls(results),
    ]


def _supervised_naive_fails(results: Results) -> Check:
    """The yardstick of a world that is hard enough."""
    driven = {
        f"{track} {CONDITION_WORDS[where]}": measure(
            results.first.drives_of(Strategy.NAIVE, where, track)
        ).laps
        for where in CONDITIONS
        for track in results.first.tracks
    }
    failed = [name for name, distance in driven.items() if distance < LAPS]
    worst = min(driven, key=lambda name: driven[name])
    return Check(
        "The supervised primary, driven naively, fails on at least one test track.",
        bool(failed),
        f"it falls short in {len(failed)} of {len(driven)} cases; "
        f"least on {worst}: {laps(driven[worst])} of {LAPS:g} laps",
    )


def _safe_beats_naive(results: Results) -> Check:
    better, numbers = [], []
    for where in CONDITIONS:
        naive = results.first.driving[Strategy.NAIVE][where]
        safe = results.first.driving[Strategy.SAFE][where]
        better.append(safe.off_road < naive.off_road and safe.laps > naive.laps)
        numbers.append(
            f"{CONDITION_WORDS[where]} it leaves in {share(safe.off_road)} of the drives "
            f"(naive: {share(naive.off_road)}) and drives {laps(safe.laps)} laps "
            f"(naive: {laps(naive.laps)})"
        )
    return Check(
        "The supervised primary with the safe strategy leaves the road less often and drives "
        "further than naively, in every condition.",
        all(better),
        "; ".join(numbers),
    )


def _naive_gets_further(results: Results) -> Check:
    better, numbers = [], []
    for where in CONDITIONS:
        before = results.first.driving[Strategy.NAIVE][where].laps
        after = results.last.driving[Strategy.NAIVE][where].laps
        better.append(after > before)
        numbers.append(f"{CONDITION_WORDS[where]} {laps(before)} laps before, {laps(after)} after")
    return Check(
        f"After iteration {results.last.number} the naive primary drives further than after "
        "supervised training, in both conditions.",
        all(better),
        "; ".join(numbers),
    )


def _takeover_falls(results: Results) -> Check:
    better, numbers = [], []
    for where in CONDITIONS:
        before = results.first.driving[Strategy.SAFE][where].takeover
        after = results.last.driving[Strategy.SAFE][where].takeover
        better.append(after < before)
        numbers.append(f"{CONDITION_WORDS[where]} {share(before)} before, {share(after)} after")
    return Check(
        "The share of the time that the reference drives, under the safe strategy, has fallen "
        f"from iteration 0 to {results.last.number}, in both conditions.",
        all(better),
        "; ".join(numbers),
    )
