"""All that the report stands on, read from the metrics of every seed."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

import pandas as pd

from pipeline.data.ledger import Ledger
from pipeline.evaluation.experiment import Experiment, all_drives, read_experiment
from pipeline.evaluation.metrics_file import MetricsFile
from pipeline.report.scratch import read_scratch
from pipeline.report.threshold import read_thresholds


@dataclass(frozen=True)
class ErrorShares:
    """Which of the supervised primary's errors are safe, on frames that the reference drove."""

    tau: float
    trained_on: float
    """share of the frames of D_0 that tau calls safe"""
    held_out: float
    """the same of drives like these that nobody trained on"""
    share: float | None
    """what share should be safe, as in the paper; None where nobody asked"""
    tau_for_share: float | None
    """the tau that makes it so on the drives held out"""


@dataclass(frozen=True, eq=False)
class Material:
    """An experiment and what stands beside it."""

    experiment: Experiment
    thresholds: Mapping[float, Experiment]
    """as `read_thresholds` gives them"""
    scratch: Experiment
    """as `read_scratch` gives it"""
    d_safe: Mapping[int, Ledger]
    """what D_safe cost, by seed"""
    errors: Mapping[int, ErrorShares]
    """by seed; a seed may have none"""

    @cached_property
    def driven(self) -> pd.DataFrame:
        """Every drive, each once: runs share iteration 0 and its drives."""
        groups = [self.experiment, *self.thresholds.values(), self.scratch]
        steps = chain.from_iterable(group.steps.values() for group in groups)
        return all_drives({(step.seed, step.name): step for step in steps}.values())

    def labels(self, seed: int, run: str, iteration: int) -> int:
        """Queries in all up to and with this iteration: D_0's, the loop's and, where the loop needs
        a safety policy, D_safe's. Of other runs the safety policies exist only to measure.
        """
        d_0 = self.experiment.steps[seed, run, 0].ledger.queries
        watched = self.experiment.specs[run].is_watched
        d_safe = self.d_safe[seed].queries if watched else 0
        return d_0 + self.experiment.queries(seed, run, iteration) + d_safe


def read_material(metrics: Path) -> Material:
    """Read every seed_<n> in `metrics`.

    Raises:
        ValueError: there is none, or a file does not hold what it should.
        FileNotFoundError: a companion of a file of drives is missing.
    """
    experiment = read_experiment(metrics)
    folders = {seed: metrics / f"seed_{seed}" for seed in experiment.seeds}
    errors = {seed: folder / "errors.json" for seed, folder in folders.items()}
    return Material(
        experiment,
        read_thresholds(metrics),
        read_scratch(metrics, experiment),
        d_safe={
            seed: MetricsFile(folder / "ledger_D_safe.json").record(Ledger)
            for seed, folder in folders.items()
        },
        errors={seed: _error_shares(file) for seed, file in errors.items() if file.is_file()},
    )


def _error_shares(path: Path) -> ErrorShares:
    file = MetricsFile(path)
    asked = file.has("share")
    return ErrorShares(
        tau=file.number("tau"),
        trained_on=file.number("trained_on", "share_safe"),
        held_out=file.number("held_out", "share_safe"),
        share=file.number("share") if asked else None,
        tau_for_share=file.number("held_out", "tau_for_share") if asked else None,
    )
