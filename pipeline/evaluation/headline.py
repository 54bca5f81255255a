"""What came out, in sentences: the headline of the report, what it cost, and what it rests on."""

from collections.abc import Iterator
from statistics import fmean

from pipeline.evaluation import tables
from pipeline.evaluation.experiment import RUNS, TRAINING, Experiment
from pipeline.evaluation.material import Material
from pipeline.evaluation.summary import LAPS
from pipeline.evaluation.tables import NAIVE, SAFE
from pipeline.evaluation.wording import count

OURS = "safedagger"


def headline(material: Material) -> str:
    """A point for the supervised stage, and for each training strategy after its last iteration."""
    experiment = material.experiment
    compared = [run for run in TRAINING if run in experiment.runs]
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
    fewer = "" if seeds == experiment.seeds else f" on {_seeds(seeds)}"
    asked = count(round(tables.spent(experiment, run, last)[0]))
    without, with_traffic = tables.estimates(experiment, "laps", run, last, NAIVE)
    yield (
        f"After iteration {last} of {RUNS[run]}{fewer}, at {asked} queries, it completes {without} "
        f"and {with_traffic}."
    )
    if run == OURS:
        laps = tables.estimates(experiment, "laps", run, last, SAFE)
        shares = tables.estimates(experiment, "takeover", run, last, SAFE)
        before = tables.estimates(experiment, "takeover", run, 0, SAFE)
        yield (
            f"With the safe strategy it completes {laps[0]} and {laps[1]}, the reference driving "
            f"{shares[0]} and {shares[1]} of the time; before the loop it was {before[0]} and "
            f"{before[1]}."
        )
    elif OURS in experiment.runs:
        yield from _against(material, run, last)


def _against(material: Material, run: str, last: int) -> Iterator[str]:
    """What SafeDAgger asked against another run, on the seeds of both, in the loop and in all."""
    experiment = material.experiment
    ours = experiment.iterations(OURS)[-1]
    seeds = [
        step.seed
        for step in experiment.of(run, last)
        if (step.seed, OURS, ours) in experiment.steps
    ]
    if not seeds:
        return
    spent = fmean(experiment.queries(seed, OURS, ours) for seed in seeds)
    theirs = fmean(experiment.queries(seed, run, last) for seed in seeds)
    labels = fmean(material.labels(seed, OURS, ours) for seed in seeds)
    their_labels = fmean(material.labels(seed, run, last) for seed in seeds)
    if spent and theirs:
        yield (
            f"SafeDAgger asked {_times(spent, theirs)} queries in the loop; with D_0, and D_safe "
            f"that only it needs, {_times(labels, their_labels)} labels ({count(round(labels))} "
            f"against {count(round(their_labels))})."
        )


def _times(ours: float, theirs: float) -> str:
    """How many times as many, in words that go before a noun."""
    factor = f"{max(ours, theirs) / min(ours, theirs):.1f}"
    if factor == "1.0":
        return "as many"
    return f"{factor} times {'fewer' if ours < theirs else 'as many'}"


def cost(material: Material) -> str:
    """Queries of the loop and outside it, and, apart, what was asked only to measure."""
    experiment = material.experiment
    run = OURS if OURS in experiment.runs else experiment.runs[0]
    last = experiment.iterations(run)[-1]
    queries, driven, _, trained = tables.spent(experiment, run, last)
    d_0 = fmean(step.ledger.queries for step in experiment.of(run, 0))
    d_safe = fmean(ledger.queries for ledger in material.d_safe.values())
    # whether the reference drives or is only looked up, each frame's deviation is known
    loop = [step.ledger for step in experiment.steps.values() if step.iteration]
    in_rollouts = sum(ledger.frames_driven - ledger.queries for ledger in loop)
    in_evaluation = sum(drive.primary_frames for step in material.driven for drive in step.drives)
    mean = ", on average" if len(experiment.of(run, last)) > 1 else ""
    spent = [count(round(number)) for number in (queries, driven, d_0, d_safe, trained)]
    return (
        f"**Cost.** The loop of {RUNS[run]} asked {spent[0]} queries a seed{mean}, in {spent[1]} "
        f"frames driven, after {spent[2]} queries for D_0 and {spent[3]} for D_safe; its last "
        f"primary was trained on {spent[4]} frames. Only to measure, never to drive or to train, "
        f"the reference was asked in {count(in_rollouts)} frames of rollouts and "
        f"{count(in_evaluation)} of evaluation, all runs and seeds together."
    )


def basis(material: Material) -> str:
    """What everything rests on, and how to get it again."""
    experiment = material.experiment
    steps = list(material.driven)
    drives = [drive for step in steps for drive in step.drives]
    starts = sorted({len({drive.start for drive in step.drives}) for step in steps})
    cars = sorted({drive.traffic for drive in drives if drive.traffic})
    alone = len(experiment.seeds) == 1
    return (
        f"**Basis.** {_seeds(experiment.seeds).capitalize()}. Test tracks: "
        f"{', '.join(sorted({drive.track for drive in drives}))}. Starts on each: "
        f"{' or '.join(map(str, starts))}. Traffic: {' or '.join(map(str, cars)) or 'no'} cars. "
        f"{count(len(drives))} drives in all: naive, in which the primary always drives; safe, in "
        "which the reference drives where the safety policy says unsafe; and optimal, where there "
        "are such, in which it drives where the primary truly deviates. In brackets are 95 % "
        "intervals, by bootstrap over seeds and starts. "
        "A number without brackets has an interval that is no wider than its last digit. "
        f"{'With one seed, no interval says how far another would be off. ' if alone else ''}"
        f"{_commands(experiment)} What is not there yet is under "
        "[What is missing](#what-is-missing)."
    )


def _commands(experiment: Experiment) -> str:
    """That reproduce each seed."""
    commands = ", ".join(f"`make experiment SEED={seed}`" for seed in experiment.seeds)
    if experiment.runs == [OURS]:
        return (
            "Each seed again: `make repro`, with this `seed` in `params.yaml`; with all strategies "
            f"beside each other, {commands}."
        )
    return f"Each seed again: {commands}."


def _seeds(seeds: list[int]) -> str:
    return f"seed{'s' if len(seeds) > 1 else ''} {', '.join(map(str, seeds))}"
