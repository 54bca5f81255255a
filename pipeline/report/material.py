"""All that the report stands on, read from the metrics of every seed."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from pipeline.evaluation.drives import each_once
from pipeline.evaluation.experiment import Experiment, Tables
from pipeline.evaluation.files import ErrorShares
from pipeline.evaluation.reading import (
    read_crowd,
    read_errors,
    read_experiment,
    read_reliability,
    read_scratch,
    read_thresholds,
)


@dataclass(frozen=True, eq=False)
class Material:
    """An experiment and what stands beside it, as `evaluation.reading` reads it."""

    experiment: Experiment
    thresholds: Tables
    scratch: Tables
    errors: Mapping[int, ErrorShares]
    curves: Experiment
    relied_on: Experiment
    """the experiment's own primaries, in the scenarios of the curves; of the seeds where that was measured"""
    in_crowd: Experiment
    """the first and the last of them in a crowd, likewise"""

    @cached_property
    def driven(self) -> pd.DataFrame:
        """Every drive, each once."""
        groups = (self.experiment, self.thresholds, self.scratch)
        return each_once(pd.concat([group.drives for group in groups if len(group.drives)]))


def read_material(metrics: Path, curves: Path | None = None) -> Material:
    """Read every seed_<n> in `metrics`, and in `curves`, if that is given; it may have none. Raises as
    `read_experiment`.
    """
    experiment = read_experiment(metrics)
    return Material(
        experiment,
        read_thresholds(metrics),
        read_scratch(metrics, experiment),
        {seed: of for seed, of in read_errors(metrics).items() if seed in experiment.seeds},
        read_reliability(curves) if curves else Experiment(specs={}),
        read_reliability(metrics),
        read_crowd(metrics),
    )
