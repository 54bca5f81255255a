"""What the paper claims (Sec. 3.3 and 5), each judged by the experiment."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

from pipeline.claims import rules
from pipeline.claims.findings import (
    WORDS,
    Finding,
    all_of,
    compare,
    falls,
    opposite,
    rises,
    unknown,
)
from pipeline.claims.query_rule import needs_fewer_queries
from pipeline.evaluation.comparison import Cell
from pipeline.evaluation.experiment import RUNS, Experiment
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import CONDITION_WORDS
from pipeline.rollout.strategies import Strategy

SHOWN = 3  # of the cells that a claim about every cell does not hold in, or may not


@dataclass(frozen=True)
class Verdict:
    """A claim, what the data says to it, and the numbers that say so."""

    claim: str
    verdict: str
    """one of WORDS"""
    observed: str
    """what decides it, in a sentence"""
    evidence: str
    """all numbers"""


@dataclass(frozen=True)
class Claim:
    """Words, and how a verdict on them is found."""

    words: str
    runs: tuple[str, ...]
    """those of RUNS that it is about; none: whatever runs there are"""
    find: Callable[[Experiment], Finding]

    def __call__(self, experiment: Experiment) -> Verdict:
        """Over the seeds that have the whole loop of all its runs; undecided where there is none."""
        seeds = [
            seed
            for seed in experiment.seeds
            if all(rules.is_whole(experiment, seed, run) for run in self.runs)
        ]
        steps = {key: step for key, step in experiment.steps.items() if key[0] in seeds}
        names = " and ".join(RUNS[run] for run in self.runs) or "any run"
        missing = f"no seed has iterations 0 to {rules.ITERATIONS} of {names}"
        found = self.find(Experiment(steps)) if steps else unknown(missing)
        sentence = f"{found.observed[0].upper()}{found.observed[1:]}."
        return Verdict(self.words, WORDS[found.holds], sentence, found.evidence)


def verdicts(experiment: Experiment) -> list[Verdict]:
    """On every claim whose runs there are, in the order of the report."""
    present = set(experiment.runs)
    return [claim(experiment) for claim in claims() if present.issuperset(claim.runs)]


def claims() -> list[Claim]:
    """All of them, in the order of the report."""
    return [
        supervised_fails,
        safe_drives_as_far,
        shows_the_trend,
        reaches_three_laps_first,
        error_falls_faster,
        takeover_falls_faster,
        fixed_tau_is_enough,
        supervised_stays_behind,
        takeover_is_larger_in_traffic,
        last_shows_the_trend,
        max_shows_the_trend,
        fewer_queries_than_dagger,
        fewer_queries_than_dagger_budget,
    ]


def _claim(words: str, *runs: str) -> Callable[[Callable[[Experiment], Finding]], Claim]:
    """Make a finding a claim."""
    return lambda find: Claim(words, runs, find)


@_claim("The supervised primary, driven naively, fails on at least one test track.")
def supervised_fails(experiment: Experiment) -> Finding:
    """The yardstick of a world that is hard enough; by `rules.falls_short`."""
    return rules.falls_short(experiment)


@_claim(
    "The safe strategy drives at least as far as the naive one, in every cell of run, iteration "
    "and condition."
)
def safe_drives_as_far(experiment: Experiment) -> Finding:
    """Holds where the laps of safe surely do not fall against naive in any cell; does not hold
    where they surely do in one.
    """
    cells = [
        opposite(
            compare(
                experiment,
                f"{RUNS[run]}, iteration {iteration}, {CONDITION_WORDS[where]}",
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


@_claim(
    f"From iteration 0 to {rules.ITERATIONS} of SafeDAgger, the naive primary gets further, and "
    "under the safe strategy the reference drives less of the time.",
    "safedagger",
)
def shows_the_trend(experiment: Experiment) -> Finding:
    """By `rules.improves`."""
    return rules.improves(experiment, "safedagger")


@_claim(
    f"Driven naively, SafeDAgger's primary does {LAPS:g} laps on all test tracks, in both "
    f"conditions, within {rules.ITERATIONS} iterations, and sooner than DAgger's.",
    "safedagger",
    "dagger",
)
def reaches_three_laps_first(experiment: Experiment) -> Finding:
    """By `rules.arrives_first`: by every single drive, and on every seed."""
    return rules.arrives_first(experiment)


@_claim(
    "The naive primary's steering error falls in SafeDAgger, and faster than in DAgger.",
    "safedagger",
    "dagger",
)
def error_falls_faster(experiment: Experiment) -> Finding:
    """By `rules.falls_faster`, of the steering MSE under the naive strategy."""
    return rules.falls_faster(experiment, "steering_mse", Strategy.NAIVE)


@_claim(
    "Under the safe strategy, the share of the time that the reference drives falls in SafeDAgger, "
    "and faster than in DAgger.",
    "safedagger",
    "dagger",
)
def takeover_falls_faster(experiment: Experiment) -> Finding:
    """By `rules.falls_faster`, of the takeover under the safe strategy."""
    return rules.falls_faster(experiment, "takeover", Strategy.SAFE)


@_claim(
    "A fixed tau is enough: with a rising one the naive primary gets no further.",
    "safedagger",
    "safedagger_rising",
)
def fixed_tau_is_enough(experiment: Experiment) -> Finding:
    """Holds where, by `rules.is_ahead`, the rising tau is not; does not hold where it is."""
    return opposite(rules.is_ahead(experiment, "safedagger_rising", "safedagger"))


@_claim(
    "More data does not let supervised learning catch up: SafeDAgger's naive primary gets further.",
    "safedagger",
    "supervised",
)
def supervised_stays_behind(experiment: Experiment) -> Finding:
    """By `rules.is_ahead`."""
    return rules.is_ahead(experiment, "safedagger", "supervised")


@_claim(
    "After supervised training, the reference drives more of the time with traffic than without, "
    "under the safe strategy (in the paper 10.81 % and 7.11 %)."
)
def takeover_is_larger_in_traffic(experiment: Experiment) -> Finding:
    """Holds where the takeover of iteration 0 surely rises with traffic, from the same starts; does
    not hold where it surely does not.
    """
    without, with_traffic = (
        Cell("safedagger", rules.START, Strategy.SAFE, (where,)) for where in CONDITIONS
    )
    words = "with traffic against without"
    return compare(experiment, words, "takeover", with_traffic, without, rises)


@_claim(f"The same trend shows in {RUNS['safedagger_last']}.", "safedagger_last")
def last_shows_the_trend(experiment: Experiment) -> Finding:
    """By `rules.improves`."""
    return rules.improves(experiment, "safedagger_last")


@_claim(f"The same trend shows in {RUNS['safedagger_max']}.", "safedagger_max")
def max_shows_the_trend(experiment: Experiment) -> Finding:
    """By `rules.improves`."""
    return rules.improves(experiment, "safedagger_max")


@_claim(
    "In the loop, without D_0 and D_safe, SafeDAgger needs fewer queries than DAgger to get as far, "
    "driven naively.",
    "safedagger",
    "dagger",
)
def fewer_queries_than_dagger(experiment: Experiment) -> Finding:
    """By `needs_fewer_queries`."""
    return needs_fewer_queries(experiment, "dagger")


@_claim(
    "In the loop, without D_0 and D_safe, SafeDAgger needs fewer queries to get as far, driven "
    "naively, than DAgger that was given as many.",
    "safedagger",
    "dagger_budget",
)
def fewer_queries_than_dagger_budget(experiment: Experiment) -> Finding:
    """By `needs_fewer_queries`."""
    return needs_fewer_queries(experiment, "dagger_budget")
