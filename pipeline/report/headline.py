"""What came out, in sentences: the head of the report."""

from collections.abc import Iterator, Sequence

from pipeline.claims.verdicts import Verdict
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment, mean
from pipeline.evaluation.wording import count, in_condition, seeds_in_words, written
from pipeline.metric import SPENT
from pipeline.report.tables import NAIVE, SAFE, estimates, failed, most_laps

QUERIES = SPENT["queries"]


def standing(judged: Sequence[Verdict]) -> str:
    """How many of the claims hold, do not hold and are undecided, and which, by their numbers."""
    words = {
        "holds": ("holds", "hold"),
        "does not hold": ("does not hold", "do not hold"),
        "undecided": ("is undecided", "are undecided"),
    }
    parts = []
    for verdict, (singular, plural) in words.items():
        numbers = [str(i) for i, one in enumerate(judged, 1) if one.verdict == verdict]
        which = f" ({', '.join(numbers)})" if numbers else ""
        parts.append(f"{len(numbers)} {singular if len(numbers) == 1 else plural}{which}")
    return f"Of the {len(judged)} [claims of the paper](#claims-of-the-paper), {', '.join(parts)}."


def headline(experiment: Experiment) -> str:
    """A point for the supervised stage, and for each training strategy after its last iteration."""
    compared = [run for run in experiment.strategies if run in experiment.runs]
    if not compared:
        return "There are no results of any training strategy."
    laps = estimates(experiment, "laps", compared[0], 0, NAIVE)
    of_all, *others = [
        f"{value}{{}} {in_condition(where)}"
        for value, where in zip(laps, experiment.conditions, strict=True)
    ]
    completed = " and ".join(
        [of_all.format(f" of {most_laps(experiment)} laps"), *(each.format("") for each in others)]
    )
    return "\n".join(
        [
            "- After supervised training alone, the primary, driven naively, completes "
            f"{completed}.",
            *(f"- {' '.join(_sentences(experiment, run))}" for run in compared),
        ]
    )


def _sentences(experiment: Experiment, run: str) -> Iterator[str]:
    """On one training strategy."""
    last = experiment.iterations(run)[-1]
    seeds = experiment.seeds_of(run, last)
    fewer = "" if seeds == experiment.seeds else f" on {seeds_in_words(seeds)}"
    asked = written(QUERIES, mean(experiment.spent, QUERIES, run=run, iteration=last))
    laps = " and ".join(estimates(experiment, "laps", run, last, NAIVE))
    yield (
        f"After iteration {last} of {experiment.title(run)}{fewer}, at {asked} queries, it completes "
        f"{laps}. {_arrival(experiment, run)}"
    )
    if run == experiment.ours:
        laps, shares, before = (
            " and ".join(estimates(experiment, metric, run, iteration, SAFE))
            for metric, iteration in (("laps", last), ("takeover", last), ("takeover", 0))
        )
        yield (
            f"With the safe strategy it completes {laps}, the reference driving {shares} of the "
            f"time; before the loop it was {before}."
        )
    elif experiment.ours in experiment.runs:
        yield from _against(experiment, experiment.ours, run, last)


def _arrival(experiment: Experiment, run: str) -> str:
    """After which iteration all naive drives did all laps first, and after which no longer."""
    laps = most_laps(experiment)
    naive = experiment.among(run=run, strategy=NAIVE)
    short = failed(naive).groupby(naive.iteration)
    full = list(short.any().index[~short.any()])
    if not full:
        return f"After no iteration did all naive drives do {laps} laps."
    first = full[0]
    asked = written(QUERIES, mean(experiment.spent, QUERIES, run=run, iteration=first))
    lost = [str(i) for i in experiment.iterations(run) if i > first and i not in full]
    later = f", but no longer after iteration {' and '.join(lost)}" if lost else ""
    return (
        f"All {short.size()[first]} naive drives did {laps} laps first after iteration {first}, at "
        f"{asked} queries{later}."
    )


def _against(experiment: Experiment, ours: str, run: str, last: int) -> Iterator[str]:
    """What our run asked against another run, on the seeds of both, in the loop and in all."""
    end = experiment.iterations(ours)[-1]
    seeds = [s for s in experiment.seeds_of(run, last) if s in experiment.seeds_of(ours, end)]
    mine, theirs = (
        among(experiment.spent, run=name, iteration=i, seed=seeds)[["queries", "labels"]].mean()
        for name, i in ((ours, end), (run, last))
    )
    if mine.queries > 0 and theirs.queries > 0:  # NaN: they share no seed
        yield (
            f"{experiment.title(ours)} asked {_times(mine.queries, theirs.queries)} queries in the loop; "
            f"with D_0, and D_safe that only it needs, {_times(mine.labels, theirs.labels)} labels "
            f"({count(mine.labels)} against {count(theirs.labels)})."
        )


def _times(ours: float, theirs: float) -> str:
    """How many times as many, in words that go before a noun."""
    factor = f"{max(ours, theirs) / min(ours, theirs):.1f}"
    if factor == "1.0":
        return "as many"
    return f"{factor} times {'fewer' if ours < theirs else 'as many'}"
