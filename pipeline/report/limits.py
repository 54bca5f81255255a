"""What SafeDAgger is short of, however its drives went: beside what is ideal, and beside DAgger."""

from collections.abc import Iterator

from pipeline.evaluation.experiment import ROLLOUT, Experiment, mean
from pipeline.evaluation.wording import NOTHING, written
from pipeline.metric import QUALITY
from pipeline.report.tables import NAIVE, OPTIMAL, SAFE, estimates
from pipeline.rollout.strategies import Strategy


def limits(experiment: Experiment, ours: str) -> str:
    """A point for each thing that was measured; empty where there is none."""
    last = experiment.iterations(ours)[-1]
    points = [
        *_unsafe_frames(experiment, ours),
        *_takeover(experiment, ours, last),
        *_steering(experiment, ours, last),
    ]
    return "\n".join(f"- {point}" for point in points)


def _unsafe_frames(experiment: Experiment, ours: str) -> Iterator[str]:
    """How many the safety policies found, in the rollouts that they decided about."""
    recall, auroc = (_range(experiment, ours, name) for name in ("recall", "auroc"))
    if recall and auroc:
        yield (
            "In the rollouts that they decided about, its safety policies called unsafe "
            f"{recall} of the truly unsafe frames (recall), with an AUROC of {auroc} (1 is perfect, "
            "0.5 is chance): means over the seeds, lowest and highest of the iterations."
        )


def _takeover(experiment: Experiment, ours: str, last: int) -> Iterator[str]:
    learned, optimal = (
        _pair(experiment, "takeover", ours, last, strategy) for strategy in (SAFE, OPTIMAL)
    )
    if learned and optimal:
        yield (
            f"After iteration {last}, the reference drives {learned} of the time (without and with "
            f"traffic) under its learned safety policies, and {optimal} under the optimal one (Eq. 2), "
            "where it drives whenever the primary truly deviates."
        )


def _steering(experiment: Experiment, ours: str, last: int) -> Iterator[str]:
    """Beside the first DAgger that there is."""
    rivals = [run for run in experiment.runs if experiment.specs[run].strategy == "dagger"]
    for rival in rivals[:1]:
        mine, theirs = (
            _pair(experiment, "steering_mse", run, last, NAIVE) for run in (ours, rival)
        )
        if mine and theirs:
            yield (
                f"After iteration {last}, the steering MSE of its primary, driven naively, is {mine} "
                f"(without and with traffic), and {theirs} in {experiment.title(rival)}."
            )


def _range(experiment: Experiment, ours: str, name: str) -> str:
    """Of one of QUALITY in the rollouts, over the iterations; empty where it is not known."""
    metric = QUALITY[name]
    means = [
        mean(experiment.quality, metric, run=ours, iteration=iteration, judged_on=ROLLOUT)
        for iteration in experiment.iterations(ours)
    ]
    known = [value for value in means if value is not None]
    ends = [written(metric, end(known)) for end in (min, max)] if known else []
    return " to ".join(dict.fromkeys(ends))


def _pair(experiment: Experiment, metric: str, run: str, iteration: int, strategy: Strategy) -> str:
    """In each condition; empty where one is not known."""
    found = estimates(experiment, metric, run, iteration, strategy)
    return "" if NOTHING in found else " and ".join(found)
