"""What the label curves are asked: how many labels it takes to become how reliable."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from pipeline.claims.findings import Finding, Judge, Row, all_of, compare, rises
from pipeline.claims.verdicts import Claim, Verdict
from pipeline.evaluation.comparison import Contrast
from pipeline.evaluation.curves import budget, cell, ended, families, last, yardstick
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import seeds_in_words

MARGIN = 0.05
"""[success per lap] a primary that surely lacks less is as reliable as another"""
TRACKS = 40
"""that both have to be driven on; fewer prove nothing"""


def is_as_reliable(found: Contrast, margin: float = MARGIN) -> bool | None:
    """Surely less than the margin below the baseline, or surely more."""
    gap = found.difference
    return True if gap.low > -margin else False if gap.high < -margin else None


def against(curves: Experiment, run: str, other: str, judge: Judge = is_as_reliable) -> Finding:
    """The success of a run at its end against another's, in all conditions together."""
    words = f"{curves.title(run)} against {curves.title(other)}"
    cells = cell(curves, run), cell(curves, other)
    found = compare(curves, Row(words, "success", *cells, judge, pairs=TRACKS))
    drives = [curves.among(run=each, iteration=last(curves, each)) for each in (run, other)]
    seeds = sorted(set.intersection(*(set(each.seed) for each in drives)))
    if not seeds:
        return found
    each = min(int(of_run.seed.isin(seeds).sum()) for of_run in drives)
    told = f"{found.evidence}; {each} drives of each, {seeds_in_words(seeds)}"
    return replace(found, observed=told, evidence=told)


def answers(curves: Experiment) -> list[Verdict]:
    """On every claim whose runs have ended, in the order of the report."""
    best = yardstick(curves)
    claims = _claims(curves, best) if best else ()
    return [Claim(f"{words}.", (), partial(_all, compared))(curves) for words, compared in claims]


type _Comparison = tuple[str, str, Judge]
"""Two runs, and who says what comes of it."""


def _all(comparisons: Sequence[_Comparison], curves: Experiment) -> Finding:
    found = [against(curves, *each) for each in comparisons]
    return found[0] if len(found) == 1 else all_of(found)


def _claims(curves: Experiment, best: str) -> Iterator[tuple[str, list[_Comparison]]]:
    """Words, and the comparisons that all have to hold."""
    specs, title, runs = curves.specs, curves.title, ended(curves)
    labels = {run: budget(curves, run) for run in runs}
    for family in families(curves).values():
        cheap = [run for run in family if 0 < labels[run] <= budget(curves, best) / 2]
        if cheap and specs[cheap[-1]].protocol == specs[best].protocol:
            words = (
                f"On at most half of its labels, {title(cheap[-1])} is as reliable as {title(best)}"
            )
            yield words, [(cheap[-1], best, is_as_reliable)]
    for run, other in product(runs, runs):
        rivals = specs[run].strategy == "safedagger" and specs[other].strategy == "dagger"
        if rivals and (labels[run], specs[run].protocol) == (labels[other], specs[other].protocol):
            yield f"{title(run)} is more reliable than {title(other)}", [(run, other, rises)]
    for idle in (run for run in runs if not specs[run].collects):
        most = [family[-1] for family in families(curves).values() if specs[family[-1]].collects]
        words = f"With its most labels, each strategy is more reliable than {title(idle)}"
        yield words, [(run, idle, rises) for run in most]
