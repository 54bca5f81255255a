"""What a verdict is made of: comparisons that hold, do not hold, or are open.

*Surely* means by the whole 95 % interval of a paired difference. Laps are the mean over the drives,
as in the paper: an interquartile mean would leave out the quarter of the drives that failed.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, Contrast, contrast
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import FORMS, interval

MARGIN = 0.1
"""[laps] a smaller difference counts as none, where that is the question"""
PAIRS = 6
"""fewer prove nothing: of five, all point the same way by chance once in sixteen times"""


WORDS = {True: "holds", False: "does not hold", None: "undecided"}
"""for what is found"""


@dataclass(frozen=True)
class Finding:
    """Something that was looked at, and the numbers."""

    holds: bool | None
    """None: open"""
    observed: str
    """what decides, with its number"""
    evidence: str
    """all numbers"""


type Judge = Callable[[Contrast], bool | None]


def rises(found: Contrast) -> bool | None:
    """Surely larger than the baseline (low > 0), or surely not (high <= 0)."""
    return True if found.difference.low > 0 else False if found.difference.high <= 0 else None


def falls(found: Contrast) -> bool | None:
    """Surely smaller than the baseline (high < 0), or surely not (low >= 0)."""
    return True if found.difference.high < 0 else False if found.difference.low >= 0 else None


def rises_or_is_full(found: Contrast) -> bool | None:
    """Rises, or is what it can be at most in every drive."""
    return found.value >= found.most or rises(found)


def exceeds(found: Contrast) -> bool | None:
    """Of laps: surely not by more than MARGIN (high <= MARGIN), or else surely (low > 0)."""
    return False if found.difference.high <= MARGIN else rises(found)


def unknown(words: str) -> Finding:
    """Open for want of data."""
    return Finding(None, words, words)


def opposite(finding: Finding) -> Finding:
    """Holds where the other does not."""
    return replace(finding, holds=None if finding.holds is None else not finding.holds)


def all_of(findings: Iterable[Finding]) -> Finding:
    """Holds where all do; does not hold where one does not. There is one at least."""
    parts = list(findings)
    counts = [sum(part.holds is state for part in parts) for state in (True, False)]
    holds = False if counts[1] else True if counts[0] == len(parts) else None
    decisive = next(part for part in parts if part.holds is holds)
    what = ", such as" if holds else f"; {WORDS[holds]}:"
    return Finding(
        holds,
        f"holds in {counts[0]} of {len(parts)} comparisons{what} {decisive.observed}",
        "; ".join(part.evidence for part in parts),
    )


@dataclass(frozen=True)
class Row:
    """A comparison: a metric in a cell against another, and who says what comes of it."""

    words: str
    metric: str
    cell: Cell
    baseline: Cell
    judge: Judge
    pairs: int = PAIRS
    """fewer prove nothing"""


def compare(experiment: Experiment, row: Row) -> Finding:
    """As its judge says; open where too few pairs are there."""
    found = contrast(experiment, row.metric, row.cell, row.baseline)
    if found is None:
        return unknown(f"{row.words}: not measured")
    form = FORMS[METRICS[row.metric].form]
    gap = found.difference
    enough = gap.count >= row.pairs
    values = f"{row.words}: {form.value(found.value)} against {form.value(found.baseline)}"
    difference = interval(gap, form.difference)
    return Finding(
        row.judge(found) if enough else None,
        f"{values} ({difference})",
        f"{values} ({difference}, {gap.count} pairs{'' if enough else ': too few'})",
    )
