"""The rule by which it is judged who needs fewer queries."""

import math

from pipeline.claims.findings import MARGIN, PAIRS, Finding, unknown
from pipeline.claims.rules import naive
from pipeline.evaluation.comparison import contrast, estimate
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import count, laps


def needs_fewer_queries(experiment: Experiment, run: str, rival: str) -> Finding:
    """A run gets as far as a rival at its best, for fewer queries of the loop.

    The rival's best is the iteration of its loop with the most naive laps, over both conditions.
    An iteration of the run gets as far if its laps lack at most MARGIN to that: surely, by the
    low end of the difference, or possibly, by the high end. Holds where one surely does for fewer
    queries than the rival's best took; does not hold where none possibly does for fewer.
    """
    loop = range(1, experiment.last + 1)
    best = max(loop, key=lambda i: _laps(experiment, rival, i))
    spent = _queries(experiment, rival, best)
    surely = possibly = math.inf
    for i in reversed(loop):  # queries only grow: the first iteration is the cheapest
        gap = contrast(experiment, "laps", naive(run, i), naive(rival, best))
        if gap is None or gap.difference.count < PAIRS:
            return unknown(f"fewer than {PAIRS} starts that both were given")
        asked = _queries(experiment, run, i)
        surely = asked if gap.difference.low >= -MARGIN else surely
        possibly = asked if gap.difference.high >= -MARGIN else possibly
    name, other = experiment.title(run), experiment.title(rival)
    far = laps(_laps(experiment, rival, best))
    when = f"surely {_after(surely, spent)}, possibly {_after(possibly, spent)}"
    return Finding(
        True if surely < spent else None if possibly < spent else False,
        f"{other}: {far} laps, its best, after {count(round(spent))} queries; {name}: as "
        f"far {when}",
        f"{other} at its best: {far} laps after {count(round(spent))} queries; {name} as "
        f"far, within {MARGIN:g}: {when}",
    )


def _laps(experiment: Experiment, run: str, iteration: int) -> float:
    """Of the naive strategy, over both conditions; 0 where no start was given in both."""
    found = estimate(experiment, "laps", naive(run, iteration))
    return found.value if found else 0.0


def _queries(experiment: Experiment, run: str, iteration: int) -> float:
    """Mean over the seeds."""
    asked = [experiment.queries(seed, run, iteration) for seed in experiment.seeds]
    return sum(asked) / len(asked)


def _after(asked: float, spent: float) -> str:
    if asked == math.inf:
        return "never"
    return f"after {count(round(asked))}" + (f" (factor {spent / asked:.1f})" if asked else "")
