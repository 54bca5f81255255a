"""The report of a comparison: markdown made from an experiment, every verdict and every number."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from pipeline.evaluation import comparison_tables as tables
from pipeline.evaluation.comparison_tables import METRICS, NAIVE, OPTIMAL, SAFE, drives_of
from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.rules import ITERATIONS
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.verdicts import verdicts
from pipeline.evaluation.wording import CONDITION_WORDS, count, table

COMPARED = {"safedagger": "SafeDAgger", "dagger": "DAgger", "supervised": "supervised learning"}


def render_comparison(
    experiment: Experiment, thresholds: Mapping[float, Experiment], figures: Mapping[str, str]
) -> str:
    """The report as markdown.

    Args:
        thresholds: as `read_thresholds` gives them.
        figures: title to place of each figure, seen from the report.
    """
    sections = [
        "# SafeDAgger beside DAgger and supervised learning",
        _headline(experiment),
        _basis(experiment),
        _claims(experiment),
        "## Over the iterations",
        "Bars are 95 % intervals. Lines stand a little apart, so that equal ones stay visible.",
        *(f"{title}:\n\n![{title}]({place})" for title, place in figures.items()),
        "## In numbers",
        "Each cell: without traffic / with traffic, with 95 % intervals. Laps are the mean over the "
        f"drives, {LAPS:g} at most, halted on leaving the road. Damage is in m²/s² per lap driven. "
        "The steering MSE is per frame that the primary drove, full lock = 1. Takeover is the share "
        "of the frames that the reference drove. Queries and frames driven are those of the loop, "
        "without D_0 and D_safe; counts of frames so far are means over the seeds.",
        *(tables.driving(experiment, metric) for metric in METRICS),
        tables.cost(experiment),
        "## Other thresholds",
        tables.thresholds(thresholds),
        "## What is missing",
        "\n".join(f"- {gap}" for gap in _gaps(experiment)) or "Nothing.",
    ]
    return "\n\n".join(sections) + "\n"


def _headline(experiment: Experiment) -> str:
    """The result, in sentences that depend on the data."""
    sentences, ours = [], 0.0
    for run, words in COMPARED.items():
        if run in experiment.runs:
            last = experiment.iterations(run)[-1]
            queries = tables.spent(experiment, run, last)[0]
            times = f" ({queries / ours:.1f} times SafeDAgger's)" if ours else ""
            ours = queries if run == "safedagger" else ours
            without, with_traffic = tables.estimates(experiment, "laps", run, last, NAIVE)
            sentences.append(
                f"After iteration {last} of {words}, at {count(round(queries))} queries{times}, "
                f"the naive primary completed {without} of {LAPS:g} laps without traffic and "
                f"{with_traffic} with traffic."
            )
    return " ".join(sentences) or "There are no results of SafeDAgger, DAgger or supervised."


def _basis(experiment: Experiment) -> str:
    """What everything rests on, and how to get it again."""
    steps = experiment.steps.values()
    drives = [drive for step in steps for drive in step.drives]
    starts = sorted({len({drive.start for drive in step.drives}) for step in steps})
    cars = sorted({drive.traffic for drive in drives if drive.traffic})
    alone = "With one seed, no interval says how far another would be off. "
    return (
        f"**Basis.** Seeds: {', '.join(map(str, experiment.seeds))}. Test tracks: "
        f"{', '.join(sorted({drive.track for drive in drives}))}. Starts on each: "
        f"{' or '.join(map(str, starts))}. Traffic: {' or '.join(map(str, cars)) or 'no'} cars. "
        f"{count(len(drives))} drives in all. In brackets are 95 % intervals, by bootstrap over "
        f"seeds and starts. {alone if len(experiment.seeds) == 1 else ''}`make experiment` "
        "reproduces seed 0, `make experiment SEED=1` another. What is not there yet is under "
        "[What is missing](#what-is-missing)."
    )


def _claims(experiment: Experiment) -> str:
    rows = [
        [one.claim, one.verdict if one.verdict == "holds" else f"**{one.verdict}**", one.evidence]
        for one in verdicts(experiment)
    ]
    return table(["Claim of the paper", "Verdict", "Numbers"], rows, words=3)


def _gaps(experiment: Experiment) -> Iterator[str]:
    """What a whole comparison has and this one has not."""
    yield from (f"{RUNS[run]}: no results." for run in RUNS if run not in experiment.runs)
    for seed, run in product(experiment.seeds, experiment.runs):
        absent = [str(i) for i in range(ITERATIONS + 1) if (seed, run, i) not in experiment.steps]
        if absent:
            yield f"{RUNS[run]}, seed {seed}: no iteration {', '.join(absent)}."
    for seed in experiment.seeds:
        yield from _missing_drives(
            [s for _, s in sorted(experiment.steps.items()) if s.seed == seed]
        )
    for run in experiment.runs:
        steps = [step for i in experiment.iterations(run) for step in experiment.of(run, i)]
        if not any(drives_of(step, OPTIMAL, where) for step in steps for where in CONDITIONS):
            yield f"{RUNS[run]}: no drives with the optimal safety policy."


def _missing_drives(steps: Sequence[Step]) -> Iterator[str]:
    """Of one seed: where there are fewer than elsewhere."""
    cells = list(product(steps, (NAIVE, SAFE), CONDITIONS))
    counts = [len(drives_of(*cell)) for cell in cells]
    for (step, strategy, where), number in zip(cells, counts, strict=True):
        if number < max(counts):
            yield (
                f"{RUNS[step.run]}, seed {step.seed}, iteration {step.iteration}: {number} of "
                f"{max(counts)} drives of {strategy}, {CONDITION_WORDS[where]}."
            )
