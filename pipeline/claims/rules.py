"""The rules by which claims about whole loops are judged."""

import math
from itertools import product

from pipeline.claims.findings import (
    Finding,
    all_of,
    compare,
    exceeds,
    falls,
    rises_or_is_full,
    unknown,
)
from pipeline.evaluation.comparison import Cell
from pipeline.evaluation.experiment import RUNS, Experiment
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import CONDITION_WORDS, laps, seeds_in_words
from pipeline.rollout.strategies import Strategy

ITERATIONS = 3
"""of a whole loop, as in the paper (Sec. 4.2)"""
START, LOOP, LAST = (0,), tuple(range(1, ITERATIONS + 1)), (ITERATIONS,)


def is_whole(experiment: Experiment, seed: int, run: str) -> bool:
    """Iterations 0 to ITERATIONS are there, with naive and safe drives in both conditions."""
    needed = set(product((*START, *LOOP), (Strategy.NAIVE, Strategy.SAFE), CONDITIONS))
    drives = experiment.among(seed=seed, run=run)
    return needed <= set(zip(drives.iteration, drives.strategy, drives.condition, strict=True))


def falls_short(experiment: Experiment) -> Finding:
    """On every seed, the supervised primary does less than LAPS naively on some test track, with or
    without traffic; does not hold where that is so on no seed.
    """
    short, shares, numbers = set(), [], []
    for seed in experiment.seeds:
        # whatever run they stand for: the primary of iteration 0 is the same
        drives = experiment.among(seed=seed, iteration=START, strategy=Strategy.NAIVE)
        if drives.empty:
            return unknown(f"seed {seed}: not measured")
        farthest = drives.groupby(["scenario", "condition"]).laps.min()
        failed = farthest[farthest < LAPS]
        worst = drives.sort_values(["laps", "scenario", "condition"]).iloc[0]
        short.add(not failed.empty)
        shares.append(f"{len(failed)} of {len(farthest)}")
        numbers.append(
            f"seed {seed}: in {shares[-1]} cases of track and traffic; worst is "
            f"{worst.scenario} {CONDITION_WORDS[worst.condition]}, {laps(worst.laps)} of {LAPS:g} "
            "laps"
        )
    return Finding(
        short.pop() if len(short) == 1 else None,
        f"less than {LAPS:g} laps in {', '.join(shares)} cases of track and traffic "
        f"({seeds_in_words(experiment.seeds)})",
        "; ".join(numbers),
    )


def arrives_first(experiment: Experiment) -> Finding:
    """On every seed, all naive drives of SafeDAgger do LAPS after some iteration, and those of
    DAgger not yet; does not hold where that is so on no seed.
    """
    arrivals = [
        [_arrival(experiment, seed, run) for run in ("safedagger", "dagger")]
        for seed in experiment.seeds
    ]
    there = sum(ours < math.inf for ours, _ in arrivals)
    sooner = [ours < theirs for ours, theirs in arrivals]
    numbers = [
        f"seed {seed}: SafeDAgger {_when(ours)}, DAgger {_when(theirs)}"
        for seed, (ours, theirs) in zip(experiment.seeds, arrivals, strict=True)
    ]
    return Finding(
        sooner[0] if len(set(sooner)) == 1 else None,
        f"within {ITERATIONS} iterations on {there} of {len(arrivals)} seeds, and sooner than DAgger's on "
        f"{sum(sooner)}",
        "; ".join(numbers),
    )


def falls_faster(experiment: Experiment, metric: str, strategy: Strategy) -> Finding:
    """In each condition a metric of SafeDAgger surely falls from iteration 0 to the last, and is
    surely lower in its loop, all iterations together, than in DAgger's: both begin at the same
    iteration 0, so that lower on the way is faster.
    """

    def cell(run: str, iterations: tuple[int, ...], where: str) -> Cell:
        return Cell(run, iterations, strategy, (where,))

    return all_of(
        compare(
            experiment,
            f"{CONDITION_WORDS[where]}, {words}",
            metric,
            cell("safedagger", iterations, where),
            cell(run, others, where),
            falls,
        )
        for where in CONDITIONS
        for words, iterations, run, others in (
            (f"iteration {ITERATIONS} against 0", LAST, "safedagger", START),
            (f"iterations 1 to {ITERATIONS} against DAgger's", LOOP, "dagger", LOOP),
        )
    )


def is_ahead(experiment: Experiment, run: str, other: str) -> Finding:
    """After the last iteration a run's naive laps, over both conditions, exceed another's: surely
    by more than 0, and not surely by MARGIN at most.
    """
    return compare(
        experiment,
        f"naive laps, {RUNS[run]} against {RUNS[other]}, iteration {ITERATIONS}",
        "laps",
        naive(run, ITERATIONS),
        naive(other, ITERATIONS),
        exceeds,
    )


def improves(experiment: Experiment, run: str) -> Finding:
    """From iteration 0 to the last, in each condition, the naive laps surely rise or all drives do
    LAPS in the end, and the takeover of safe surely falls.
    """
    return all_of(
        compare(
            experiment,
            f"{CONDITION_WORDS[where]}, {metric} of {strategy}, iteration {ITERATIONS} against 0",
            metric,
            Cell(run, LAST, strategy, (where,)),
            Cell(run, START, strategy, (where,)),
            judge,
        )
        for where in CONDITIONS
        for metric, strategy, judge in (
            ("laps", Strategy.NAIVE, rises_or_is_full),
            ("takeover", Strategy.SAFE, falls),
        )
    )


def naive(run: str, iteration: int) -> Cell:
    """The naive drives of both conditions."""
    return Cell(run, (iteration,), Strategy.NAIVE, CONDITIONS)


def _arrival(experiment: Experiment, seed: int, run: str) -> float:
    """The first iteration after which each naive drive does LAPS; infinity where none is."""
    drives = experiment.among(seed=seed, run=run, strategy=Strategy.NAIVE)
    farthest = drives.groupby("iteration").laps.min()
    return min(farthest.index[farthest >= LAPS], default=math.inf)


def _when(iteration: float) -> str:
    return "never" if iteration == math.inf else f"after iteration {iteration}"
