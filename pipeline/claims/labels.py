"""What the label curves are asked: how many labels it takes to become how reliable."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from pipeline.claims.findings import WORDS, Finding, Judge, Row, compare, rises
from pipeline.claims.verdicts import Verdict
from pipeline.evaluation.comparison import Contrast, naive
from pipeline.evaluation.curves import budget, ended, families, last, yardstick
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import seeds_in_words

MARGIN = 0.05
"""[success per lap] a primary that surely lacks less is as reliable as another"""
PAIRS = 40
"""of seed and track, that both have to be driven on; fewer prove nothing: where none of 80 pairs of drives,
without and with traffic, differ, up to 4.5 % still may, by an exact 95 % interval
"""


def is_as_reliable(found: Contrast, margin: float = MARGIN) -> bool | None:
    """Surely less than the margin below the baseline, or surely more."""
    gap = found.difference
    return True if gap.low > -margin else False if gap.high < -margin else None


def against(curves: Experiment, run: str, other: str, judge: Judge = is_as_reliable) -> Finding:
    """The success of a run at its end against another's, in all conditions together."""
    mine, theirs = (naive(curves, each, last(curves, each)) for each in (run, other))
    found = compare(curves, Row("success", "success", mine, theirs, judge, pairs=PAIRS))
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
    judged = []
    for words, run, other, judge in _claims(curves, best) if best else ():
        found = against(curves, run, other, judge)
        title, rival = curves.title(run), curves.title(other)
        claim = f"{title}: {words.format(rival)}."
        judged.append(Verdict(claim, WORDS[found.holds], found.observed, found.evidence))
    return judged


def _claims(curves: Experiment, best: str) -> Iterator[tuple[str, str, str, Judge]]:
    """Words, the run that they are of, the one that it is compared with, and who says what comes of
    it.
    """
    specs, runs, ways = curves.specs, ended(curves), families(curves).values()
    labels = {run: budget(curves, run) for run in runs}
    for family in ways:
        cheap = [run for run in family if 0 < 2 * labels[run] <= budget(curves, best)]
        if cheap and specs[cheap[-1]].protocol == specs[best].protocol:
            words = "as reliable as {}, on at most half of its labels in the loop"
            yield words, cheap[-1], best, is_as_reliable
    dagger = [run for run in runs if specs[run].strategy == "dagger"]
    in_the_paper = next((each for each in ways if specs[each[0]].strategy == "safedagger"), [])
    for rivals in (dagger, in_the_paper):
        for run, other in product(runs, rivals):
            alike = (labels[run], specs[run].protocol) == (labels[other], specs[other].protocol)
            if specs[run].strategy == "safedagger" and alike and run != other:
                yield "more reliable than {}", run, other, rises
    for idle in (run for run in runs if not specs[run].collects):
        for run in (family[-1] for family in ways if family[-1] != idle):
            yield "more reliable than {}", run, idle, rises
