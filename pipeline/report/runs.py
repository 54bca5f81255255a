"""What the runs are, in plain words, and what their loops did."""

from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import count, share


def runs(experiment: Experiment) -> str:
    """A line for each run that there is."""
    return "\n".join(
        f"- {experiment.title(run)}: {experiment.specs[run].words}{_loop(experiment, run)}"
        for run in experiment.runs
    )


def _loop(experiment: Experiment, run: str) -> str:
    """What was driven and added after iteration 0, means over the seeds; nothing without a loop."""
    last = experiment.iterations(run)[-1]
    if not last:
        return ""
    spent = among(experiment.spent, run=run, iteration=last)
    return (
        f" Loop: {count(spent.frames_driven.mean())} frames driven, "
        f"{share(spent.takeover.mean())} of them by the reference; "
        f"{count(spent.frames_selected.mean())} added{_taus(experiment, run)}."
    )


def _taus(experiment: Experiment, run: str) -> str:
    """Of the safety policies, where these decide in rollouts: one, or that of each iteration."""
    if not experiment.specs[run].is_watched:
        return ""
    first = among(experiment.quality, run=run).groupby("iteration").tau.first()
    taus = [f"{tau:g}" for tau in first]
    if len(set(taus)) == 1:
        return f"; tau {taus[0]}"
    return f"; tau {', '.join(taus)} after iterations {', '.join(map(str, first.index))}"
