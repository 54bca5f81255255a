"""The tables of the safety policies: how well they find unsafe frames, and what tau decides."""

from collections.abc import Iterable, Mapping
from statistics import fmean

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.metrics_file import SafetyQuality
from pipeline.evaluation.wording import NOTHING, ratio, share, table
from pipeline.report.material import ErrorShares
from pipeline.report.tables import SAFE, by_iteration, estimates
from pipeline.report.threshold import RUN

QUALITY = {
    "auroc": ("AUROC", ratio),
    "recall": ("Recall of unsafe", share),
    "precision": ("Precision of unsafe", share),
    "share_unsafe": ("Truly unsafe", share),
    "share_predicted_unsafe": ("Called unsafe", share),
}
BY_TAU = ("laps", "damage_per_lap", "takeover", "switches_per_lap", "takeover_length")
"""metrics that are given for each tau"""


def safety(experiment: Experiment) -> str:
    """How well the safety policies of SafeDAgger and its variants find the unsafe frames."""

    def cells(run: str, iteration: int) -> list[str]:
        steps = experiment.of(run, iteration)
        taus = sorted({step.tau for step in steps})
        held_out = [step.held_out for step in steps]
        rollouts = [step.next_rollout for step in steps]
        measures = [
            f"{form(mean_quality(held_out, name))} / {form(mean_quality(rollouts, name))}"
            for name, (_, form) in QUALITY.items()
        ]
        return [", ".join(f"{tau:g}" for tau in taus), *measures]

    runs = [run for run in experiment.runs if experiment.specs[run].is_watched]
    header = ["tau", *(words for words, _ in QUALITY.values())]
    return by_iteration(experiment, runs, header, cells)


def thresholds(found: Mapping[float, Experiment]) -> str:
    """The supervised primary under the safe strategy, a row for each tau."""
    rows = []
    for tau, experiment in found.items():
        unsafe = mean_quality([step.held_out for step in experiment.of(RUN, 0)], "share_unsafe")
        cells = [" / ".join(estimates(experiment, metric, RUN, 0, SAFE)) for metric in BY_TAU]
        rows.append([f"{tau:g}", ", ".join(map(str, experiment.seeds)), share(unsafe), *cells])
    header = ["tau", "Seeds", "Truly unsafe", *(METRICS[metric].title for metric in BY_TAU)]
    return table(header, rows)


def errors(found: Mapping[int, ErrorShares]) -> str:
    """Which errors of the supervised primary are safe, a row for each seed."""
    rows = [
        [
            str(seed),
            f"{each.tau:g}",
            share(each.trained_on),
            share(each.held_out),
            NOTHING
            if each.tau_for_share is None
            else f"{each.tau_for_share:.3g} ({share(each.share)})",
        ]
        for seed, each in sorted(found.items())
    ]
    header = ["Seed", "tau", "Safe of D_0", "Safe of those held out", "tau for the paper's share"]
    return table(header, rows)


def mean_quality(qualities: Iterable[SafetyQuality | None], name: str) -> float | None:
    """One of QUALITY, over those in which it is defined; None where it is in none."""
    values = [getattr(each, name) for each in qualities if each]
    known = [value for value in values if value is not None]
    return fmean(known) if known else None
