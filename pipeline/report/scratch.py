"""What the warm start of a primary is worth: beside one trained from scratch on the same D_i."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pipeline.claims.findings import PAIRS
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, contrast, estimate
from pipeline.evaluation.drives import read_drives
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS
from pipeline.evaluation.wording import CONDITION_WORDS, FORMS, NOTHING, interval, table
from pipeline.rollout.strategies import Strategy

WARM, SCRATCH = "warm", "scratch"
_DRIVES = re.compile(r"seed_(?P<seed>\d+)/drives_scratch_(?P<iteration>\d+)\.csv")


def read_scratch(metrics: Path, experiment: Experiment) -> Experiment:
    """Two runs, WARM and SCRATCH: the iterations that a seed has both ways.

    Reads seed_<n>/drives_scratch_<i>.csv; all else of such a step is its warm counterpart's, and
    without one, that began with the same primary, there is nothing to compare it with.

    Raises:
        ValueError: a file does not hold what it should.
    """
    steps = {}
    for path in sorted(metrics.glob("seed_*/drives_scratch_*.csv")):
        named = _DRIVES.fullmatch(path.relative_to(metrics).as_posix())
        if not named:
            continue
        seed, iteration = int(named["seed"]), int(named["iteration"])
        warm, drives = (
            experiment.steps.get((seed, experiment.ours or "", iteration)),
            read_drives(path),
        )
        if warm and set(warm.drives.begun_with) == set(drives.begun_with):
            steps[seed, WARM, iteration] = replace(warm, run=WARM)
            steps[seed, SCRATCH, iteration] = replace(
                warm, run=SCRATCH, name=f"scratch_{iteration}", drives=drives
            )
    return Experiment(steps, {})


def warm_or_scratch(pairs: Experiment) -> str:
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


def _rows(pairs: Experiment, metric: str, words: str, iteration: int) -> Iterator[list[str]]:
    """Without and with traffic."""
    form = FORMS[METRICS[metric].form]
    for where in CONDITIONS:
        cells = [_naive(run, iteration, (where,)) for run in (WARM, SCRATCH)]
        values = [estimate(pairs, metric, cell) for cell in cells]
        found = contrast(pairs, metric, cells[1], cells[0])
        gap = interval(found.difference, form.difference) if found else NOTHING
        what = f"{words}, {CONDITION_WORDS[where]}"
        yield [f"D_{iteration}", what, *(interval(value, form.value) for value in values), gap]


def _further(pairs: Experiment, iteration: int) -> str:
    """By the naive laps over both conditions, in pairs."""
    found = contrast(pairs, "laps", *(_naive(run, iteration) for run in (SCRATCH, WARM)))
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
        f"{interval(gap, FORMS[METRICS['laps'].form].difference)} laps, in {gap.count} pairs of drives."
    )


def _naive(run: str, iteration: int, conditions: tuple[str, ...] = CONDITIONS) -> Cell:
    return Cell(run, (iteration,), Strategy.NAIVE, conditions)
