"""What a whole experiment has, and this one has not."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import pandas as pd

from pipeline.claims.verdicts import claims
from pipeline.evaluation.curves import last
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import in_condition
from pipeline.report.material import Material
from pipeline.report.tables import NAIVE, OPTIMAL, SAFE


def gaps(material: Material, pictures: Mapping[str, Mapping[int, str]]) -> list[str]:
    """One line for each thing that is missing; `pictures` are those that each seed should have, title to
    seed to place.
    """
    experiment, curves = material.experiment, material.curves
    wanted = {run: range(len(experiment.specs[run].iterations) + 1) for run in experiment.runs}
    ends = {run: (0, last(experiment, run)) for run in experiment.runs}
    curve_ends = {run: (0, last(curves, run)) for run in curves.specs}
    return [
        *(
            _without_results(experiment, run)
            for run in experiment.specs
            if run not in experiment.runs
        ),
        *experiment.left_out,
        *_missing_iterations(experiment, wanted),
        *_missing_drives(experiment),
        *_beside_the_loops(material),
        *(
            f"{title}, seed {seed}: no picture."
            for title, places in pictures.items()
            for seed in experiment.seeds
            if seed not in places
        ),
        *_alone(experiment, "Reliability", material.relied_on, wanted),
        *_alone(experiment, "Reliability in a crowd", material.in_crowd, ends),
        *(
            f"Label curves: {each}"
            for each in (
                *curves.left_out,
                *_missing_iterations(curves, curve_ends),
                *(
                    f"seed {seed}: no results."
                    for seed in experiment.seeds
                    if curves.seeds and seed not in curves.seeds
                ),
            )
        ),
    ]


def _without_results(experiment: Experiment, run: str) -> str:
    """A run, and how many claims wait for it."""
    waiting = sum(run in claim.runs for claim in claims(experiment))
    verdicts = f", hence no verdict on {waiting} claim{'s' * (waiting > 1)}" if waiting else ""
    return f"{experiment.title(run)}: no results{verdicts}."


def _alone(
    experiment: Experiment, title: str, measured: Experiment, wanted: Mapping[str, Sequence[int]]
) -> Iterator[str]:
    """Of its seeds, for which primaries it was not measured how far they can be relied on alone."""
    for seed in experiment.seeds:
        if seed not in measured.seeds:
            yield f"{title}, seed {seed}: not measured."
            continue
        there = set(experiment.among(seed=seed).run)
        own = {run: whole for run, whole in wanted.items() if run in there}
        yield from (
            f"{title}: {each}" for each in _missing_iterations(measured.of_seeds(seed), own)
        )
    for each in measured.left_out:
        if each not in experiment.left_out:
            yield f"{title}: {each}"


def _missing_iterations(
    experiment: Experiment, wanted: Mapping[str, Sequence[int]]
) -> Iterator[str]:
    for seed, (run, whole) in product(experiment.seeds, wanted.items()):
        there = set(experiment.among(seed=seed, run=run).iteration)
        absent = [str(i) for i in whole if i not in there]
        if len(absent) == len(whole):
            yield f"{experiment.title(run)}, seed {seed}: no results."
        elif absent:
            yield f"{experiment.title(run)}, seed {seed}: no iteration {', '.join(absent)}."


def _missing_drives(experiment: Experiment) -> Iterator[str]:
    for _, drives in experiment.drives.groupby("seed"):
        yield from _fewer_than_elsewhere(experiment, drives)
    for run in experiment.runs:
        if run in experiment.strategies and experiment.among(run=run, strategy=OPTIMAL).empty:
            yield f"{experiment.title(run)}: no drives with the optimal safety policy."


def _fewer_than_elsewhere(experiment: Experiment, drives: pd.DataFrame) -> Iterator[str]:
    """Of one seed: cells with fewer drives than the fullest."""
    steps = sorted(set(zip(drives.run, drives.iteration, strict=True)))
    found = drives.groupby(["run", "iteration", "strategy", "condition"]).size()
    cells = [(*step, s, c) for step, s, c in product(steps, (NAIVE, SAFE), experiment.conditions)]
    counts = found.reindex(cells, fill_value=0)
    for cell, number in zip(cells, counts, strict=True):
        run, iteration, strategy, where = cell
        if number < counts.max():
            yield (
                f"{experiment.title(run)}, seed {drives.seed.iloc[0]}, iteration {iteration}: "
                f"{number} of {counts.max()} drives of {strategy}, {in_condition(where)}."
            )


def _beside_the_loops(material: Material) -> Iterator[str]:
    if material.thresholds.drives.empty:
        yield "Other thresholds: no drives with safety policies of other tau."
    if not len(material.scratch.drives):
        yield "Warm start or from scratch: no primary trained from scratch."
    for seed in material.experiment.seeds:
        if seed not in material.errors:
            yield f"Seed {seed}: no errors.json, which says which errors are safe."
        elif material.errors[seed].held_out.tau_for_share is None:
            yield f"Seed {seed}: no tau for the paper's share of safe frames in errors.json."
