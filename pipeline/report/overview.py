"""What an experiment has come to, a row a step: to be read in a terminal."""

from collections.abc import Iterator

from pipeline.evaluation.experiment import Experiment, mean
from pipeline.evaluation.wording import written
from pipeline.metric import SPENT
from pipeline.report.tables import NAIVE, SAFE, failed, measured

HEADER = (
    "Run",
    "Iteration",
    "Seeds",
    "Laps, naive",
    "Laps, safe",
    "Takeover, safe",
    "Failed, naive",
    "Queries",
)
"""Pairs are without / with traffic. Failed are drives that did not do all laps; queries are those of
the loop so far, the mean over the seeds.
"""


def overview(experiment: Experiment) -> Iterator[list[str]]:
    """A row for each run and iteration, over its seeds, under HEADER."""
    queries = SPENT["queries"]
    for run in experiment.runs:
        for iteration in experiment.iterations(run):
            drives = experiment.among(run=run, iteration=iteration)
            short = failed(drives[drives.strategy == NAIVE])
            yield [
                experiment.title(run),
                str(iteration),
                ", ".join(map(str, experiment.seeds_of(run, iteration))),
                measured(experiment, drives, "laps", NAIVE),
                measured(experiment, drives, "laps", SAFE),
                measured(experiment, drives, "takeover", SAFE),
                f"{short.sum()} of {len(short)}",
                written(queries, mean(experiment.spent, queries, run=run, iteration=iteration)),
            ]
