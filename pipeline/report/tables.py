"""The tables with a row for each run and iteration: every metric with its interval, and the cost."""

from collections.abc import Callable
from statistics import fmean

from pipeline.data.ledger import Ledger, cumulative
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import CONDITIONS
from pipeline.evaluation.wording import FORMS, brief_interval, count, share, table
from pipeline.report.material import Material
from pipeline.rollout.strategies import DRIVING, Strategy

NAIVE, SAFE, OPTIMAL = DRIVING
STRATEGIES: dict[str, tuple[Strategy, ...]] = {
    "laps": DRIVING,
    "laps_iqm": (NAIVE,),
    "damage_per_lap": DRIVING,
    "steering_mse": (NAIVE, SAFE),
    "takeover": (SAFE, OPTIMAL),
    "switches_per_lap": (SAFE, OPTIMAL),
    "takeover_length": (SAFE, OPTIMAL),
}
"""The metrics that have a table, and the driving strategies that each is given of."""


def driving(experiment: Experiment, metric: str) -> str:
    """One metric under the strategies that were driven, and of the steering MSE the frames that it
    rests on.
    """
    driven = set(experiment.drives.strategy)
    strategies = [strategy for strategy in STRATEGIES[metric] if strategy in driven]
    header = [f"{METRICS[metric].title}, {strategy}" for strategy in strategies]
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
        [experiment.title(run), str(iteration), *cells(run, iteration)]
        for run in runs
        for iteration in experiment.iterations(run)
    ]
    return table(["Run", "Iteration", *header], rows)


def estimates(
    experiment: Experiment, metric: str, run: str, iteration: int, strategy: Strategy
) -> list[str]:
    """Without and with traffic, each with its interval."""
    form = FORMS[METRICS[metric].form].value
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
    drives = experiment.among(run=run, iteration=iteration, strategy=strategy)
    return [count(int(among(drives, condition=each).primary_frames.sum())) for each in CONDITIONS]
