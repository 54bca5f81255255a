"""What the report rests on, in sentences: what was asked, what was driven, and how to get it again."""

from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import D_SAFE, Experiment
from pipeline.evaluation.wording import count, seeds_in_words
from pipeline.report.material import Material


def cost(material: Material) -> str:
    """Queries of the loop and outside it, and, apart, what was asked only to measure."""
    experiment = material.experiment
    ours = experiment.ours
    run = ours if ours in experiment.runs else experiment.runs[0]
    last = experiment.iterations(run)[-1]
    spent = among(experiment.spent, run=run, iteration=last)
    first = among(experiment.ledgers, run=[run, D_SAFE], iteration=0)
    before = first.groupby("run").queries.mean()
    # whether the reference drives or is only looked up, each frame's deviation is known
    loop = experiment.ledgers[experiment.ledgers.iteration > 0]
    in_rollouts = (loop.frames_driven - loop.queries).sum()
    in_evaluation = material.driven.primary_frames.sum()
    mean = ", on average" if len(spent) > 1 else ""
    return (
        f"**Cost.** The loop of {experiment.title(run)} asked {count(spent.queries.mean())} queries a seed{mean}, in "
        f"{count(spent.frames_driven.mean())} frames driven, after {count(before[run])} queries for D_0 and "
        f"{count(before[D_SAFE])} for D_safe; its last primary was trained on "
        f"{count(spent.frames_trained.mean())} frames. Only to measure, never to drive or to train, "
        f"the reference was asked in {count(in_rollouts)} frames of rollouts and "
        f"{count(in_evaluation)} of evaluation, all runs and seeds together."
    )


def basis(material: Material) -> str:
    """What everything rests on, and how to get it again."""
    experiment = material.experiment
    drives = material.driven
    starts = sorted(set(drives.groupby(["seed", "step"]).start.nunique()))
    cars = sorted(set(drives.traffic[drives.traffic > 0]))
    return (
        f"**Basis.** {seeds_in_words(experiment.seeds).capitalize()}. Test tracks: "
        f"{', '.join(sorted(set(drives.scenario)))}. Starts on each: "
        f"{' or '.join(map(str, starts))}. Traffic: {' or '.join(f'{number:g}' for number in cars) or 'no'} cars. "
        f"{count(len(drives))} drives in all: naive, in which the primary always drives; safe, in "
        "which the reference drives where the safety policy says unsafe; and optimal, where there "
        "are such, in which it drives where the primary truly deviates. "
        f"{_commands(experiment)} Runs, seeds and pictures that are not there are "
        "under [What is missing](#what-is-missing)."
    )


def certainty(experiment: Experiment) -> str:
    """What the intervals say, and what they cannot say."""
    most = experiment.drives.groupby(["run", "iteration", "strategy", "condition"]).size().max()
    allowed = 1 - 0.05 ** (1 / most)  # the share of failures that n drives hide once in 20 times
    alone = len(experiment.seeds) == 1
    return (
        "**Intervals.** In brackets are 95 % intervals, by bootstrap over seeds and starts; a metric "
        f"in an iteration and condition rests on {most} drives at most, hence they are wide. A number "
        "without brackets has an interval that is no wider than its last digit, which is not "
        "certainty: resampling cannot show a failure that did not happen. "
        f"{most} drives that all went well still allow that {100 * allowed:.0f} % would fail (at "
        "95 %; about 3/n for n drives), or more, since the drives of a seed share a primary."
        f"{' With one seed, no interval says how far another would be off.' if alone else ''}"
    )


def _commands(experiment: Experiment) -> str:
    """That reproduce each seed."""
    commands = ", ".join(f"`make experiment SEED={seed}`" for seed in experiment.seeds)
    if experiment.runs == [experiment.ours]:
        return (
            "Each seed again: `make repro`, with this `seed` in `params.yaml`; with all strategies "
            f"beside each other, {commands}."
        )
    return f"Each seed again: {commands}."
