"""What an experiment has come to, a row a step: to be read in a terminal."""

from collections.abc import Iterator

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import Experiment, mean
from pipeline.evaluation.wording import written
from pipeline.metric import COLLECTED, SPENT
from pipeline.report.tables import NAIVE, SAFE, failed, measured

SHOWN = (("laps", NAIVE), ("laps", SAFE), ("takeover", SAFE))
COSTS = (SPENT["queries"], SPENT["labels"], COLLECTED["failures"])
HEADER = (
    "Run",
    "Iteration",
    "Seeds",
    *(f"{METRICS[metric].title}, {strategy}" for metric, strategy in SHOWN),
    f"Failed, {NAIVE}",
    *(metric.title for metric in COSTS),
)
"""Pairs are without / with traffic. Failed are drives that did not do all laps; queries are those of
the loop so far, failures what went wrong while it collected, means over the seeds.
"""


def overview(experiment: Experiment) -> Iterator[list[str]]:
    """A row for each run and iteration, over its seeds, under HEADER."""
    for run in experiment.runs:
        for iteration in experiment.iterations(run):
            drives = experiment.among(run=run, iteration=iteration)
            short = failed(drives[drives.strategy == NAIVE])
            yield [
                experiment.title(run),
                str(iteration),
                ", ".join(map(str, experiment.seeds_of(run, iteration))),
                *(measured(experiment, drives, *each) for each in SHOWN),
                f"{short.sum()} of {len(short)}",
                *(
                    written(metric, mean(experiment.spent, metric, run=run, iteration=iteration))
                    for metric in COSTS
                ),
            ]
