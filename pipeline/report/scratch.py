"""What the warm start of a primary is worth: beside one trained from scratch on the same D_i."""

from collections.abc import Iterator

from pipeline.claims.findings import PAIRS
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import contrast, estimate, naive
from pipeline.evaluation.experiment import Tables
from pipeline.evaluation.reading import SCRATCH, WARM
from pipeline.evaluation.wording import FORMS, NOTHING, in_condition, interval, table


def warm_or_scratch(pairs: Tables) -> str:
    """Which of the two gets further, and the table that says so."""
    iterations = pairs.iterations(SCRATCH)
    rows = [
        row
        for iteration in iterations
        for metric, words in (("laps", "laps"), ("steering_mse", "steering MSE"))
        for row in _rows(pairs, metric, words, iteration)
    ]
    header = ["Trained on", "Driven naively", "Warm", "From scratch", "From scratch minus warm"]
    sentences = " ".join(_further(pairs, iteration) for iteration in iterations)
    return f"{sentences}\n\n{table(header, rows, words=2)}"


def _rows(pairs: Tables, metric: str, words: str, iteration: int) -> Iterator[list[str]]:
    """In each condition."""
    form = FORMS[METRICS[metric].form]
    for where in pairs.conditions:
        warm, scratch = (naive(pairs, run, iteration, where) for run in (WARM, SCRATCH))
        values = [interval(estimate(pairs, metric, each), form.value) for each in (warm, scratch)]
        found = contrast(pairs, metric, scratch, warm)
        gap = interval(found.difference, form.difference) if found else NOTHING
        yield [f"D_{iteration}", f"{words}, {in_condition(where)}", *values, gap]


def _further(pairs: Tables, iteration: int) -> str:
    """By the naive laps over all conditions, in pairs."""
    found = contrast(pairs, "laps", *(naive(pairs, run, iteration) for run in (SCRATCH, WARM)))
    if found is None:
        return f"On D_{iteration}, no start was given to both."
    gap = found.difference
    if gap.count >= PAIRS and gap.low > 0:
        verdict = "the primary trained from scratch gets further"
    elif gap.count >= PAIRS and gap.high < 0:
        verdict = "the primary with the warm start gets further"
    else:
        verdict = "which primary gets further is undecided"
    return (
        f"On D_{iteration}, {verdict}: over both conditions, from scratch minus warm is "
        f"{interval(gap, FORMS[METRICS['laps'].form].difference)} laps, in {gap.count} pairs "
        "of seed, track and start."
    )
