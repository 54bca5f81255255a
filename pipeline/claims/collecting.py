"""Whether anything went wrong while a loop collected: the paper concludes (Sec. 5) that a primary
learns "without any catastrophic experience".

Failures are taken as independent of each other.
"""

import numpy as np
import pandas as pd
from scipy.stats import binomtest, chi2

from pipeline.claims.findings import PAIRS, Finding, falls, unknown
from pipeline.driving.metrics import KINDS
from pipeline.evaluation import statistics
from pipeline.evaluation.comparison import RESAMPLING_SEED, Contrast
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.statistics import ratio_of_sums
from pipeline.evaluation.wording import FORMS, count, interval, seeds_in_words, share

UNCOUNTED = "not measured: its ledgers do not count failures"


def is_unharmed(experiment: Experiment, run: str) -> Finding:
    """No failure in the whole loop, on any seed that counts them; does not hold where there is one."""
    loop = _loop(experiment, run)
    if loop.empty:
        return unknown(UNCOUNTED)
    failures, told = loop.failures.sum(), _in_words(loop)
    kinds = ", ".join(f"{kind.title} {count(loop[kind.part].sum())}" for kind in KINDS.values())
    put_back = f"put back {count(loop.put_back.sum())}"
    return Finding(bool(failures == 0), told, f"{told} ({kinds.lower()}; {put_back})")


def fails_less_often(experiment: Experiment, run: str, rival: str) -> Finding:
    """A run has surely fewer failures per frame driven than a rival, or surely not, on the seeds that
    count them for both.

    On one seed by the exact interval of its share of all failures, beside its share of the frames
    (of two Poisson counts, one is binomial given their sum); on several by that of the difference,
    resampled by seed and iteration. Open where there is no failure at all.
    """
    mine, theirs = _on_shared_seeds(_loop(experiment, run), _loop(experiment, rival))
    if mine.empty:
        return unknown(UNCOUNTED)
    told = f"{experiment.title(run)}: {_in_words(mine)}; {experiment.title(rival)}: {_in_words(theirs)}"
    seeds = _seeds(mine)
    words = f"({seeds_in_words(seeds)})"
    if not mine.failures.sum() + theirs.failures.sum():
        return Finding(None, f"no failure in either {words}", told)
    holds, found = (_exact if len(seeds) == 1 else _resampled)(mine, theirs)
    return Finding(holds, f"{found} {words}", f"{told}; {found}")


def _loop(experiment: Experiment, run: str) -> pd.DataFrame:
    """The ledgers of its iterations by seed and iteration, of the seeds where each counts failures."""
    whole = list(experiment.specs[run].iterations)
    found = among(experiment.ledgers, run=run, iteration=whole)
    counted = found.groupby("seed").failures.transform(lambda failures: failures.notna().all())
    return found[counted.astype(bool)].set_index(["seed", "iteration"])


def _on_shared_seeds(*loops: pd.DataFrame) -> list[pd.DataFrame]:
    shared = set.intersection(*(set(_seeds(loop)) for loop in loops))
    return [loop[loop.index.isin(shared, level="seed")] for loop in loops]


def _seeds(loop: pd.DataFrame) -> list[int]:
    return sorted(loop.index.unique("seed"))


def _in_words(loop: pd.DataFrame) -> str:
    """All of it, and how many failures there may be: Garwood's exact bound of a Poisson count."""
    failures, frames, drives = loop[["failures", "frames_driven", "drives"]].sum()
    most = chi2.ppf(0.95, 2 * (failures + 1)) / 2 * 1000 / frames
    plural = "s" * (failures != 1)
    return (
        f"{count(failures)} failure{plural} in {count(frames)} frames of {count(drives)} drives "
        f"({seeds_in_words(_seeds(loop))}), {most:.2g} in 1,000 frames at most (upper 95 % bound)"
    )


def _exact(mine: pd.DataFrame, theirs: pd.DataFrame) -> tuple[bool | None, str]:
    failures, frames = (
        [int(loop[name].sum()) for loop in (mine, theirs)] for name in ("failures", "frames_driven")
    )
    found = binomtest(failures[0], sum(failures)).proportion_ci()
    expected = frames[0] / sum(frames)
    return (
        True if found.high < expected else False if found.low >= expected else None,
        f"{failures[0]} of {sum(failures)} failures [{share(found.low)}, {share(found.high)}] "
        f"in {share(expected)} of the frames of both",
    )


def _resampled(mine: pd.DataFrame, theirs: pd.DataFrame) -> tuple[bool | None, str]:
    shared = mine.index.intersection(theirs.index).sort_values()
    ours, others = (
        loop.loc[shared, ["failures", "frames_driven"]].to_numpy() / (1, 1000)
        for loop in (mine, theirs)
    )
    strata = [(seed, "") for seed, _ in shared]
    generator = np.random.default_rng(RESAMPLING_SEED)
    gap = statistics.difference(ratio_of_sums, ours, others, strata, generator)
    if gap is None:
        return None, "nothing was driven"
    rate, other = (float(part / whole) for part, whole in (ours.sum(axis=0), others.sum(axis=0)))
    form = FORMS["amount"]
    enough = gap.count >= PAIRS
    return (
        falls(Contrast(rate, other, gap)) if enough else None,
        f"{form.value(rate)} against {form.value(other)} in 1,000 frames "
        f"({interval(gap, form.difference)}, {gap.count} pairs{'' if enough else ': too few'})",
    )
