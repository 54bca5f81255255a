"""What the runs are, in plain words, and what their loops did."""

from statistics import fmean

from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import count, share
from pipeline.report import tables


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
    _, driven, by_reference, _ = tables.spent(experiment, run, last)
    added = fmean(
        sum(experiment.steps[step.seed, run, i].ledger.frames_selected for i in range(1, last + 1))
        for step in experiment.of(run, last)
    )
    return (
        f" Loop: {count(round(driven))} frames driven, {share(by_reference)} of them by the "
        f"reference; {count(round(added))} added{_taus(experiment, run)}."
    )


def _taus(experiment: Experiment, run: str) -> str:
    """Of the safety policies, where these decide in rollouts: one, or that of each iteration."""
    if not experiment.specs[run].is_watched:
        return ""
    iterations = experiment.iterations(run)
    taus = [f"{experiment.of(run, i)[0].tau:g}" for i in iterations]
    if len(set(taus)) == 1:
        return f"; tau {taus[0]}"
    return f"; tau {', '.join(taus)} after iterations {', '.join(map(str, iterations))}"
