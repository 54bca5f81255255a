"""What came out, in sentences: the head of the report."""

from collections.abc import Iterator, Sequence
from statistics import fmean

from pipeline.claims.verdicts import Verdict
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import LAPS
from pipeline.evaluation.wording import count, seeds_in_words
from pipeline.report import tables
from pipeline.report.material import Material
from pipeline.report.tables import NAIVE, SAFE


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


def headline(material: Material) -> str:
    """A point for the supervised stage, and for each training strategy after its last iteration."""
    experiment = material.experiment
    compared = [run for run in experiment.strategies if run in experiment.runs]
    if not compared:
        return "There are no results of any training strategy."
    without, with_traffic = tables.estimates(experiment, "laps", compared[0], 0, NAIVE)
    return "\n".join(
        [
            f"- After supervised training alone, the primary, driven naively, completes {without} "
            f"of {LAPS:g} laps without traffic and {with_traffic} with traffic.",
            *(f"- {' '.join(_sentences(material, run))}" for run in compared),
        ]
    )


def _sentences(material: Material, run: str) -> Iterator[str]:
    """On one training strategy."""
    experiment = material.experiment
    last = experiment.iterations(run)[-1]
    seeds = [step.seed for step in experiment.of(run, last)]
    fewer = "" if seeds == experiment.seeds else f" on {seeds_in_words(seeds)}"
    asked = count(round(tables.spent(experiment, run, last)[0]))
    without, with_traffic = tables.estimates(experiment, "laps", run, last, NAIVE)
    yield (
        f"After iteration {last} of {experiment.title(run)}{fewer}, at {asked} queries, it completes {without} "
        f"and {with_traffic}. {_arrival(experiment, run)}"
    )
    if run == experiment.ours:
        laps = tables.estimates(experiment, "laps", run, last, SAFE)
        shares = tables.estimates(experiment, "takeover", run, last, SAFE)
        before = tables.estimates(experiment, "takeover", run, 0, SAFE)
        yield (
            f"With the safe strategy it completes {laps[0]} and {laps[1]}, the reference driving "
            f"{shares[0]} and {shares[1]} of the time; before the loop it was {before[0]} and "
            f"{before[1]}."
        )
    elif experiment.ours in experiment.runs:
        yield from _against(material, experiment.ours, run, last)


def _arrival(experiment: Experiment, run: str) -> str:
    """After which iteration all naive drives did all laps first, and after which no longer."""
    naive = experiment.among(run=run, strategy=NAIVE).groupby("iteration").laps
    full = list(naive.min().index[naive.min() >= LAPS])
    if not full:
        return f"After no iteration did all naive drives do {LAPS:g} laps."
    first = full[0]
    asked = count(round(tables.spent(experiment, run, first)[0]))
    lost = [str(i) for i in experiment.iterations(run) if i > first and i not in full]
    later = f", but no longer after iteration {' and '.join(lost)}" if lost else ""
    return (
        f"All {naive.size()[first]} naive drives did {LAPS:g} laps first after iteration {first}, at "
        f"{asked} queries{later}."
    )


def _against(material: Material, ours: str, run: str, last: int) -> Iterator[str]:
    """What our run asked against another run, on the seeds of both, in the loop and in all."""
    experiment = material.experiment
    end = experiment.iterations(ours)[-1]
    seeds = [
        step.seed for step in experiment.of(run, last) if (step.seed, ours, end) in experiment.steps
    ]
    if not seeds:
        return
    spent = fmean(experiment.queries(seed, ours, end) for seed in seeds)
    theirs = fmean(experiment.queries(seed, run, last) for seed in seeds)
    labels = fmean(material.labels(seed, ours, end) for seed in seeds)
    their_labels = fmean(material.labels(seed, run, last) for seed in seeds)
    if spent and theirs:
        yield (
            f"{experiment.title(ours)} asked {_times(spent, theirs)} queries in the loop; with D_0, and D_safe "
            f"that only it needs, {_times(labels, their_labels)} labels ({count(round(labels))} "
            f"against {count(round(their_labels))})."
        )


def _times(ours: float, theirs: float) -> str:
    """How many times as many, in words that go before a noun."""
    factor = f"{max(ours, theirs) / min(ours, theirs):.1f}"
    if factor == "1.0":
        return "as many"
    return f"{factor} times {'fewer' if ours < theirs else 'as many'}"
