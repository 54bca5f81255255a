"""The report: markdown made from all metrics, every verdict, every number and every gap. Its words
are in report.md.j2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.claims.findings import MARGIN, PAIRS
from pipeline.claims.labels import MARGIN as LABEL_MARGIN
from pipeline.claims.labels import answers
from pipeline.claims.verdicts import verdicts
from pipeline.driving.features import STANDSTILL
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.curves import yardstick
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import D_SAFE, Experiment
from pipeline.evaluation.templates import template
from pipeline.evaluation.wording import count, seeds_in_words, share
from pipeline.metric import shown
from pipeline.report import labels, tables
from pipeline.report.gaps import gaps
from pipeline.report.headline import headline, standing
from pipeline.report.material import Material
from pipeline.report.scratch import warm_or_scratch
from pipeline.report.shortfalls import falls_short, limits


@dataclass(frozen=True)
class Pictures:
    """Where the pictures lie, seen from the report."""

    result: str | None
    """the one at its head; None where there is nothing to draw"""
    labels: str | None
    """the label curves; None where there are none"""
    figures: Mapping[str, str]
    """over the iterations, by title"""
    by_seed: Mapping[str, Mapping[int, str]]
    """by title and seed"""
    tracks: Mapping[str, str]
    """by title"""


def render_report(material: Material, pictures: Pictures) -> str:
    """The report as markdown."""
    experiment = material.experiment
    judged = verdicts(experiment)
    cells = experiment.drives.groupby(["run", "iteration", "strategy", "condition"])
    return template(Path(__file__).with_name("report.md.j2"), in_words=seeds_in_words).render(
        experiment=experiment,
        material=material,
        pictures=pictures,
        seeds=experiment.seeds,
        standing=standing(judged),
        headline=headline(experiment),
        cost=_cost(material),
        basis=_basis(material),
        fullest=cells.size().max(),
        runs=runs(experiment),
        verdicts=judged,
        pairs=PAIRS,
        margin=MARGIN,
        laps=tables.most_laps(experiment),
        standstill=STANDSTILL,
        tables=tables,
        metrics=shown(METRICS, "tables"),
        watched=any(experiment.specs[run].is_watched for run in experiment.runs),
        warm_or_scratch=warm_or_scratch,
        falls_short=falls_short,
        limits=limits,
        gaps=gaps(material, pictures.by_seed),
        curves=material.curves,
        relied_on=material.relied_on,
        in_crowd=material.in_crowd,
        best=yardstick(material.curves),
        labels=labels,
        label_margin=LABEL_MARGIN,
        answers=answers(material.curves),
    )


def runs(experiment: Experiment) -> str:
    """A line for each run that there is."""
    return "\n".join(
        f"- {experiment.title(run)}: {experiment.specs[run].words}{_loop(experiment, run)}"
        for run in experiment.runs
    )


def _cost(material: Material) -> dict[str, Any]:
    """Queries of the loop and outside it, and, apart, what was asked only to measure."""
    experiment = material.experiment
    run = experiment.ours if experiment.ours in experiment.runs else experiment.runs[0]
    spent = among(experiment.spent, run=run, iteration=experiment.iterations(run)[-1])
    first = among(experiment.ledgers, run=[run, D_SAFE], iteration=0)
    before = first.groupby("run").queries.mean()
    # whether the reference drives or is only looked up, each frame's deviation is known
    loop = experiment.ledgers[experiment.ledgers.iteration > 0]
    means = spent[["queries", "frames_driven", "frames_trained"]].mean()
    return {
        "run": experiment.title(run),
        "seeds": len(spent),
        **{str(name): value for name, value in means.items()},
        "d_0": before[run],
        "d_safe": before[D_SAFE],
        "in_rollouts": (loop.frames_driven - loop.queries).sum(),
        "in_evaluation": material.driven.primary_frames.sum(),
    }


def _basis(material: Material) -> dict[str, Any]:
    """What was driven."""
    drives = material.driven
    # a column only where conditions differ in it
    cars = drives.get("traffic", pd.Series(dtype=float))
    return {
        "tracks": sorted(set(drives.scenario)),
        "starts": sorted(set(drives.groupby(["seed", "step"]).start.nunique())),
        "cars": [f"{number:g}" for number in sorted(set(cars[cars > 0]))],
        "drives": len(drives),
    }


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
