"""The tables with a row for each run and iteration: every metric with its interval, and the cost."""

from collections.abc import Callable
from statistics import fmean

from pipeline.data.ledger import Ledger, cumulative
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import RUNS, Experiment
from pipeline.evaluation.summary import CONDITIONS
from pipeline.evaluation.wording import amount, brief_interval, count, laps, share, table
from pipeline.report.material import Material
from pipeline.rollout.strategies import DRIVING, Strategy

NAIVE, SAFE, OPTIMAL = DRIVING
METRICS: dict[str, tuple[str, Callable[[float], str], tuple[Strategy, ...]]] = {
    "laps": ("Laps", laps, DRIVING),
    "laps_iqm": ("Interquartile mean of laps", laps, (NAIVE,)),
    "damage_per_lap": ("Damage per lap", amount, DRIVING),
    "steering_mse": ("Steering MSE", amount, (NAIVE, SAFE)),
    "takeover": ("Takeover", share, (SAFE, OPTIMAL)),
    "switches_per_lap": ("Switches per lap", amount, (SAFE, OPTIMAL)),
    "takeover_length": ("Frames of a takeover", amount, (SAFE, OPTIMAL)),
}
"""Of a metric: its title, its form, and the driving strategies that it is given of."""


def driving(experiment: Experiment, metric: str) -> str:
    """One metric under the strategies that were driven, and of the steering MSE the frames that it
    rests on.
    """
    title, _, of_metric = METRICS[metric]
    driven = {drive.strategy for step in experiment.steps.values() for drive in step.drives}
    strategies = [strategy for strategy in of_metric if strategy in driven]
    header = [f"{title}, {strategy}" for strategy in strategies]
    if metric == "steering_mse":
        header += [f"Frames of the MSE, {strategy}" for strategy in strategies]

    def cells(run: str, iteration: int) -> list[str]:
        found = [estimates(experiment, metric, run, iteration, each) for each in strategies]
        if metric == "steering_mse":
            found += [_frames(experiment, run, iteration, each) for each in strategies]
        return [" / ".join(pair) for pair in found]

    return by_iteration(experiment, experiment.runs, header, cells)


def cost(material: Material) -> str:
    """What the loop has cost so far, and what the reference labelled in all: means over the seeds."""
    experiment = material.experiment
    header = [
        "Queries so far",
        "Labels in all",
        "Frames driven so far",
        "Of them by the reference",
        "Frames trained on",
    ]

    def cells(run: str, iteration: int) -> list[str]:
        queries, driven, takeover, trained = spent(experiment, run, iteration)
        seeds = [step.seed for step in experiment.of(run, iteration)]
        labels = fmean(material.labels(seed, run, iteration) for seed in seeds)
        counts = [count(round(number)) for number in (queries, labels, driven, trained)]
        return [*counts[:3], share(takeover if iteration else None), counts[3]]

    return by_iteration(experiment, experiment.runs, header, cells)


def by_iteration(
    experiment: Experiment,
    runs: list[str],
    header: list[str],
    cells: Callable[[str, int], list[str]],
) -> str:
    """A row for each run and iteration."""
    rows = [
        [RUNS[run], str(iteration), *cells(run, iteration)]
        for run in runs
        for iteration in experiment.iterations(run)
    ]
    return table(["Run", "Iteration", *header], rows)


def estimates(
    experiment: Experiment, metric: str, run: str, iteration: int, strategy: Strategy
) -> list[str]:
    """Without and with traffic, each with its interval."""
    form = METRICS[metric][1]
    cells = [Cell(run, (iteration,), strategy, (where,)) for where in CONDITIONS]
    return [brief_interval(estimate(experiment, metric, cell), form) for cell in cells]


def spent(experiment: Experiment, run: str, iteration: int) -> tuple[float, float, float, float]:
    """Queries and frames driven in the loop so far, the share of these by the reference, and frames
    trained on: means over the seeds.
    """
    nothing = Ledger(0, 0, 0, 0, 0.0)
    rows = []
    for step in experiment.of(run, iteration):
        loop = [experiment.steps[step.seed, run, i].ledger for i in range(1, iteration + 1)]
        total = cumulative(loop)[-1] if loop else nothing
        rows.append(
            (total.queries, total.frames_driven, total.takeover, step.ledger.frames_trained)
        )
    queries, driven, takeover, trained = (fmean(column) for column in zip(*rows, strict=True))
    return queries, driven, takeover, trained


def _frames(experiment: Experiment, run: str, iteration: int, strategy: Strategy) -> list[str]:
    """Frames that the primary drove, without and with traffic."""
    steps = experiment.of(run, iteration)
    drives = [[d for step in steps for d in step.drives_of(strategy, c)] for c in CONDITIONS]
    return [count(sum(drive.primary_frames for drive in each)) for each in drives]
