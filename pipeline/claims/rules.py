"""How the claims are judged that are more than comparisons side by side."""

import math
from dataclasses import replace
from itertools import product

import pandas as pd

from pipeline.claims.findings import (
    MARGIN,
    PAIRS,
    Finding,
    Row,
    all_of,
    compare,
    falls,
    opposite,
    unknown,
)
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, contrast, estimate, naive
from pipeline.evaluation.drives import each_once
from pipeline.evaluation.experiment import Experiment, mean
from pipeline.evaluation.wording import count, in_condition, laps, seeds_in_words
from pipeline.metric import SPENT
from pipeline.rollout.strategies import Strategy
from pipeline.runs import FIRST

SHOWN = 3  # of the cells that a claim about every cell does not hold in, or may not


def is_whole(experiment: Experiment, seed: int, run: str) -> bool:
    """Iterations 0 to the last are there, with naive and safe drives in all conditions."""
    told = range(experiment.last + 1), (Strategy.NAIVE, Strategy.SAFE), experiment.conditions
    drives = experiment.among(seed=seed, run=run)
    found = set(zip(drives.iteration, drives.strategy, drives.condition, strict=True))
    return set(product(*told)) <= found


def falls_short(experiment: Experiment) -> Finding:
    """On every seed, the supervised primary does less than all laps naively on some test track, in
    some condition; does not hold where that is so on no seed.
    """
    most = f"{experiment.most(METRICS['laps']):g}"
    short, shares, numbers = set(), [], []
    for seed in experiment.seeds:
        # whatever run they stand for, but one of its own: the primary of iteration 0 is the same
        drives = experiment.among(seed=seed, step=FIRST, strategy=Strategy.NAIVE)
        if drives.empty:
            return unknown(f"seed {seed}: not measured")
        failed = _missing(drives).groupby([drives.scenario, drives.condition]).any()
        worst = drives.sort_values(["laps", "scenario", "condition"]).iloc[0]
        short.add(bool(failed.any()))
        shares.append(f"{failed.sum()} of {len(failed)}")
        numbers.append(
            f"seed {seed}: in {shares[-1]} cases of track and traffic; worst is "
            f"{worst.scenario} {in_condition(worst.condition)}, {laps(worst.laps)} of {most} "
            "laps"
        )
    return Finding(
        short.pop() if len(short) == 1 else None,
        f"less than {most} laps in {', '.join(shares)} cases of track and traffic "
        f"({seeds_in_words(experiment.seeds)})",
        "; ".join(numbers),
    )


def drives_as_far(experiment: Experiment) -> Finding:
    """Holds where the laps of safe surely do not fall against naive in any cell of run, iteration
    and condition; does not hold where they surely do in one.
    """
    cells = []
    once = each_once(experiment.drives)
    driven = set(zip(once.run, once.iteration, strict=True))
    for run in experiment.runs:
        for iteration, where in product(experiment.iterations(run), experiment.conditions):
            if (run, iteration) not in driven:
                continue
            words = f"{experiment.title(run)}, iteration {iteration}, {in_condition(where)}"
            safe, alone = (
                Cell(run, (iteration,), each, (where,)) for each in (Strategy.SAFE, Strategy.NAIVE)
            )
            cells.append(opposite(compare(experiment, Row(words, "laps", safe, alone, falls))))
    others = sorted((cell for cell in cells if not cell.holds), key=lambda cell: cell.holds is None)
    shown = [cell.evidence for cell in others[:SHOWN]]
    rest = [f"and {len(others) - SHOWN} more"] if len(others) > SHOWN else []
    surely = f"surely in {len(cells) - len(others)} of {len(cells)} cells"
    return replace(all_of(cells), evidence="; ".join([surely, *shown, *rest]))


def arrives_first(experiment: Experiment, run: str, rival: str) -> Finding:
    """On every seed, all naive drives of a run do all laps after some iteration, and those of a
    rival not yet; does not hold where that is so on no seed.
    """
    drives = experiment.among(strategy=Strategy.NAIVE)
    short = _missing(drives).groupby([drives.run, drives.seed, drives.iteration]).any()

    def arrival(seed: int, run: str) -> float:
        """The first iteration after which each naive drive does; infinity where none is."""
        of_run = short.xs((run, seed))
        return min(of_run.index[~of_run], default=math.inf)

    arrivals = {seed: (arrival(seed, run), arrival(seed, rival)) for seed in experiment.seeds}
    there = sum(ours < math.inf for ours, _ in arrivals.values())
    sooner = [ours < theirs for ours, theirs in arrivals.values()]
    name, other = experiment.title(run), experiment.title(rival)
    return Finding(
        sooner[0] if len(set(sooner)) == 1 else None,
        f"within {experiment.last} iterations on {there} of {len(arrivals)} seeds, and sooner than "
        f"{other}'s on {sum(sooner)}",
        "; ".join(
            f"seed {seed}: {name} {_when(ours)}, {other} {_when(theirs)}"
            for seed, (ours, theirs) in arrivals.items()
        ),
    )


def needs_fewer_queries(experiment: Experiment, run: str, rival: str) -> Finding:
    """A run gets as far as a rival at its best, for fewer queries of the loop.

    The rival's best is the iteration of its loop with the most naive laps, over all conditions.
    An iteration of the run gets as far if its laps lack at most MARGIN to that: surely, by the
    low end of the difference, or possibly, by the high end. Holds where one surely does for fewer
    queries than the rival's best took; does not hold where none possibly does for fewer.
    """
    loop = range(1, experiment.last + 1)
    found = {i: estimate(experiment, "laps", naive(experiment, rival, i)) for i in loop}
    far = {i: each.value if each else 0.0 for i, each in found.items()}
    best = max(loop, key=far.__getitem__)
    spent = _queries(experiment, rival, best)
    surely = possibly = math.inf
    for i in reversed(loop):  # queries only grow: the first iteration is the cheapest
        cells = naive(experiment, run, i), naive(experiment, rival, best)
        gap = contrast(experiment, "laps", *cells)
        if gap is None or gap.difference.count < PAIRS:
            return unknown(f"fewer than {PAIRS} starts that both were given")
        asked = _queries(experiment, run, i)
        surely = asked if gap.difference.low >= -MARGIN else surely
        possibly = asked if gap.difference.high >= -MARGIN else possibly
    name, other = experiment.title(run), experiment.title(rival)
    when = f"surely {_after(surely, spent)}, possibly {_after(possibly, spent)}"
    return Finding(
        True if surely < spent else None if possibly < spent else False,
        f"{other}: {laps(far[best])} laps, its best, after {count(spent)} queries; {name}: as "
        f"far {when}",
        f"{other} at its best: {laps(far[best])} laps after {count(spent)} queries; {name} as "
        f"far, within {MARGIN:g}: {when}",
    )


def _missing(drives: pd.DataFrame) -> "pd.Series[bool]":
    """Which did less than all laps."""
    return drives.laps < drives["task.laps"]


def _queries(experiment: Experiment, run: str, iteration: int) -> float:
    """Mean over the seeds."""
    return mean(experiment.spent, SPENT["queries"], run=run, iteration=iteration) or 0.0


def _when(iteration: float) -> str:
    return "never" if iteration == math.inf else f"after iteration {iteration}"


def _after(asked: float, spent: float) -> str:
    if asked == math.inf:
        return "never"
    return f"after {count(asked)}" + (f" (factor {spent / asked:.1f})" if asked else "")
