"""What the paper claims (Sec. 3.3 and 5), each judged by paired differences of the comparison.

Laps are the mean over drives, as in the paper: an interquartile mean would leave out the quarter
of the drives that failed. *Surely* means by the whole 95 % interval. What is claimed of some runs
rests on the seeds that have the whole loop of each; where there is none, it is undecided.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps
from itertools import product

from pipeline.evaluation.comparison import Cell, Contrast, contrast
from pipeline.evaluation.experiment import RUNS, Experiment
from pipeline.evaluation.summary import CONDITIONS, LAPS, condition
from pipeline.evaluation.wording import CONDITION_WORDS, amount, count, laps, share
from pipeline.policies.strategies import Strategy

ITERATIONS = 3
"""of the whole loop, as in the paper (Sec. 4.2)"""
LOOP = tuple(range(1, ITERATIONS + 1))
MARGIN = 0.1
"""[laps] what is less than this apart counts as equal, where equal is the question"""
WORDS = {True: "holds", False: "does not hold", None: "undecided"}
FORMS: dict[str, tuple[Callable[[float], str], float, str]] = {
    "laps": (laps, 1, "+z.2f"),
    "takeover": (share, 100, "+z.1f"),
    "steering_mse": (amount, 1, "+z.2g"),
}
"""of a metric: form of a value; scale and form of a difference"""


@dataclass(frozen=True)
class Verdict:
    """A claim, what the data says to it, and the numbers that it rests on."""

    claim: str
    verdict: str
    """one of WORDS"""
    evidence: str


@dataclass(frozen=True)
class Finding:
    """A part of a verdict."""

    holds: bool | None
    """None: open"""
    evidence: str


type Judge = Callable[[Contrast], bool | None]


def verdicts(experiment: Experiment) -> list[Verdict]:
    """On every claim, in the order of the report."""
    return [
        safe_drives_as_far(experiment),
        reaches_three_laps_first(experiment),
        error_falls_faster(experiment),
        takeover_falls_faster(experiment),
        fixed_tau_is_enough(experiment),
        supervised_stays_behind(experiment),
        takeover_is_larger_in_traffic(experiment),
        last_shows_the_trend(experiment),
        max_shows_the_trend(experiment),
        fewer_queries_than_dagger(experiment),
        fewer_queries_than_dagger_budget(experiment),
    ]


def _claim(
    words: str, *runs: str
) -> Callable[[Callable[[Experiment], Finding]], Callable[[Experiment], Verdict]]:
    """A verdict on `words` from a finding, on the seeds that have the whole loop of all `runs`."""

    def judged(find: Callable[[Experiment], Finding]) -> Callable[[Experiment], Verdict]:
        @wraps(find)
        def verdict(experiment: Experiment) -> Verdict:
            seeds = [seed for seed in experiment.seeds if _is_whole(experiment, seed, runs)]
            if runs and not seeds:
                names = " and ".join(RUNS[run] for run in runs)
                finding = Finding(None, f"no seed has iterations 0 to {ITERATIONS} of {names}")
            else:
                finding = find(_restrict(experiment, seeds))
            return Verdict(words, WORDS[finding.holds], finding.evidence)

        return verdict

    return judged


@_claim(
    "The safe strategy drives at least as far as the naive one, in every cell of run, iteration "
    "and condition."
)
def safe_drives_as_far(experiment: Experiment) -> Finding:
    """Holds where safe is surely not behind (low >= 0) in each cell; does not hold where it surely
    is (high < 0) in one.
    """
    cells = [
        _opposite(
            _compare(
                experiment,
                f"{RUNS[run]}, iteration {iteration}, {CONDITION_WORDS[where]}:",
                "laps",
                Cell(run, (iteration,), Strategy.SAFE, (where,)),
                Cell(run, (iteration,), Strategy.NAIVE, (where,)),
                _falls,
            )
        )
        for run in experiment.runs
        for iteration, where in product(experiment.iterations(run), CONDITIONS)
    ]
    others = [cell.evidence for cell in cells if not cell.holds]
    surely = f"surely so in {len(cells) - len(others)} of {len(cells)} cells"
    return Finding(_all_of(cells).holds, "; ".join([surely, *others]))


@_claim(
    f"Driven naively, SafeDAgger's primary does all {LAPS:g} laps on every test track, in both "
    f"conditions, within {ITERATIONS} iterations, and sooner than DAgger's.",
    "safedagger",
    "dagger",
)
def reaches_three_laps_first(experiment: Experiment) -> Finding:
    """On a seed it is so where every naive drive does LAPS after some iteration up to ITERATIONS,
    and in DAgger not yet. Holds where it is so on all seeds; does not hold where on none.
    """
    sooner, numbers = set(), []
    for seed in experiment.seeds:
        ours, theirs = (_arrival(experiment, seed, run) for run in ("safedagger", "dagger"))
        sooner.add(ours <= ITERATIONS and ours < theirs)
        when = [f"after iteration {i}" if i <= ITERATIONS else "never" for i in (ours, theirs)]
        numbers.append(f"seed {seed}: SafeDAgger {when[0]}, DAgger {when[1]}")
    return Finding(sooner.pop() if len(sooner) == 1 else None, "; ".join(numbers))


@_claim(
    "The naive primary's steering error falls in SafeDAgger, and faster than in DAgger.",
    "safedagger",
    "dagger",
)
def error_falls_faster(experiment: Experiment) -> Finding:
    """As `_falls_faster`, of the steering MSE under the naive strategy."""
    return _falls_faster(experiment, "steering_mse", Strategy.NAIVE)


@_claim(
    "The share of the time that the reference drives, under the safe strategy, falls in "
    "SafeDAgger, and faster than in DAgger.",
    "safedagger",
    "dagger",
)
def takeover_falls_faster(experiment: Experiment) -> Finding:
    """As `_falls_faster`, of the takeover under the safe strategy."""
    return _falls_faster(experiment, "takeover", Strategy.SAFE)


@_claim(
    "A fixed tau is enough: with a rising one the naive primary does not get further.",
    "safedagger",
    "safedagger_rising",
)
def fixed_tau_is_enough(experiment: Experiment) -> Finding:
    """Holds where the rising tau is not ahead, as `_is_ahead`; does not hold where it is."""
    return _opposite(_is_ahead(experiment, "safedagger_rising", "safedagger"))


@_claim(
    "More supervised data does not catch up: the naive primary gets further in SafeDAgger.",
    "safedagger",
    "supervised",
)
def supervised_stays_behind(experiment: Experiment) -> Finding:
    """Holds where SafeDAgger is ahead of supervised, as `_is_ahead`; does not hold where not."""
    return _is_ahead(experiment, "safedagger", "supervised")


@_claim(
    "Under the safe strategy, the reference drives a larger share of the time with traffic than "
    "without, after supervised training (in the paper: 10.81 % and 7.11 %)."
)
def takeover_is_larger_in_traffic(experiment: Experiment) -> Finding:
    """Holds where it is surely larger, pairing equal starts; does not hold where surely not."""
    with_traffic, without = (
        Cell("safedagger", (0,), Strategy.SAFE, (where,)) for where in ("traffic", "no_traffic")
    )
    return _compare(
        experiment, "with traffic and without:", "takeover", with_traffic, without, _rises
    )
