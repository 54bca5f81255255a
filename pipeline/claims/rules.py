"""The rules by which claims about whole loops are judged."""

import math
from dataclasses import replace
from itertools import product

from pipeline.claims.findings import (
    Finding,
    all_of,
    compare,
    exceeds,
    falls,
    opposite,
    rises,
    rises_or_is_full,
    unknown,
)
from pipeline.evaluation.comparison import Cell
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import CONDITION_WORDS, laps, seeds_in_words
from pipeline.rollout.strategies import Strategy

START = (0,)
SHOWN = 3  # of the cells that a claim about every cell does not hold in, or may not


def is_whole(experiment: Experiment, seed: int, run: str) -> bool:
    """Iterations 0 to the last are there, with naive and safe drives in both conditions."""
    iterations = range(experiment.last + 1)
    needed = set(product(iterations, (Strategy.NAIVE, Strategy.SAFE), CONDITIONS))
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


def arrives_first(experiment: Experiment, run: str, rival: str) -> Finding:
    """On every seed, all naive drives of a run do LAPS after some iteration, and those of a rival
    not yet; does not hold where that is so on no seed.
    """
    arrivals = [
        [_arrival(experiment, seed, each) for each in (run, rival)] for seed in experiment.seeds
    ]
    there = sum(ours < math.inf for ours, _ in arrivals)
    sooner = [ours < theirs for ours, theirs in arrivals]
    name, other = experiment.title(run), experiment.title(rival)
    numbers = [
        f"seed {seed}: {name} {_when(ours)}, {other} {_when(theirs)}"
        for seed, (ours, theirs) in zip(experiment.seeds, arrivals, strict=True)
    ]
    return Finding(
        sooner[0] if len(set(sooner)) == 1 else None,
        f"within {experiment.last} iterations on {there} of {len(arrivals)} seeds, and sooner than "
        f"{other}'s on {sum(sooner)}",
        "; ".join(numbers),
    )


def falls_faster(
    experiment: Experiment, run: str, rival: str, metric: str, strategy: Strategy
) -> Finding:
    """In each condition a metric of a run surely falls from iteration 0 to the last, and is surely
    lower in its loop, all iterations together, than in a rival's: both begin at the same iteration
    0, so that lower on the way is faster.
    """
    last, loop = experiment.last, tuple(range(1, experiment.last + 1))

    def cell(run: str, iterations: tuple[int, ...], where: str) -> Cell:
        return Cell(run, iterations, strategy, (where,))

    return all_of(
        compare(
            experiment,
            f"{CONDITION_WORDS[where]}, {words}",
            metric,
            cell(run, iterations, where),
            cell(other, others, where),
            falls,
        )
        for where in CONDITIONS
        for words, iterations, other, others in (
            (f"iteration {last} against 0", (last,), run, START),
            (f"iterations 1 to {last} against {experiment.title(rival)}'s", loop, rival, loop),
        )
    )


def is_ahead(experiment: Experiment, run: str, other: str) -> Finding:
    """After the last iteration a run's naive laps, over both conditions, exceed another's: surely
    by more than 0, and not surely by MARGIN at most.
    """
    last = experiment.last
    return compare(
        experiment,
        f"naive laps, {experiment.title(run)} against {experiment.title(other)}, iteration {last}",
        "laps",
        naive(run, last),
        naive(other, last),
        exceeds,
    )


def improves(experiment: Experiment, run: str) -> Finding:
    """From iteration 0 to the last, in each condition, the naive laps surely rise or all drives do
    LAPS in the end, and the takeover of safe surely falls.
    """
    last = experiment.last
    return all_of(
        compare(
            experiment,
            f"{CONDITION_WORDS[where]}, {metric} of {strategy}, iteration {last} against 0",
            metric,
            Cell(run, (last,), strategy, (where,)),
            Cell(run, START, strategy, (where,)),
            judge,
        )
        for where in CONDITIONS
        for metric, strategy, judge in (
            ("laps", Strategy.NAIVE, rises_or_is_full),
            ("takeover", Strategy.SAFE, falls),
        )
    )


def drives_as_far(experiment: Experiment) -> Finding:
    """Holds where the laps of safe surely do not fall against naive in any cell of run, iteration
    and condition; does not hold where they surely do in one.
    """
    cells = [
        opposite(
            compare(
                experiment,
                f"{experiment.title(run)}, iteration {iteration}, {CONDITION_WORDS[where]}",
                "laps",
                Cell(run, (iteration,), Strategy.SAFE, (where,)),
                Cell(run, (iteration,), Strategy.NAIVE, (where,)),
                falls,
            )
        )
        for run in experiment.runs
        for iteration, where in product(experiment.iterations(run), CONDITIONS)
    ]
    others = sorted((cell for cell in cells if not cell.holds), key=lambda cell: cell.holds is None)
    shown = [cell.evidence for cell in others[:SHOWN]]
    rest = [f"and {len(others) - SHOWN} more"] if len(others) > SHOWN else []
    surely = f"surely in {len(cells) - len(others)} of {len(cells)} cells"
    return replace(all_of(cells), evidence="; ".join([surely, *shown, *rest]))


def takes_over_more_in_traffic(experiment: Experiment, run: str) -> Finding:
    """Holds where the takeover of iteration 0 surely rises with traffic, from the same starts; does
    not hold where it surely does not.
    """
    without, with_it = (Cell(run, START, Strategy.SAFE, (where,)) for where in CONDITIONS)
    words = "with traffic against without"
    return compare(experiment, words, "takeover", with_it, without, rises)


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
