"""The tables of a comparison: every metric, what it cost, and the thresholds, with intervals."""

from collections.abc import Callable, Mapping
from statistics import fmean

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.outcomes import Outcome
from pipeline.evaluation.summary import CONDITIONS, condition
from pipeline.evaluation.threshold import RUN
from pipeline.evaluation.wording import NOTHING, amount, count, laps, share, table
from pipeline.policies.strategies import DRIVING, Strategy

NAIVE, SAFE, OPTIMAL = DRIVING
METRICS: dict[str, tuple[str, Callable[[float], str], tuple[Strategy, ...]]] = {
    "laps": ("Laps", laps, DRIVING),
    "damage_per_lap": ("Damage per lap", amount, DRIVING),
    "steering_mse": ("Steering MSE", amount, (NAIVE, SAFE)),
    "takeover": ("Takeover", share, (SAFE, OPTIMAL)),
    "switches_per_lap": ("Switches per lap", amount, (SAFE, OPTIMAL)),
    "takeover_length": ("Frames of a takeover", amount, (SAFE, OPTIMAL)),
}
"""Of a metric: its title, its form, and the driving strategies that it is given of."""


def driving(experiment: Experiment, metric: str) -> str:
    """One metric, and of the steering MSE the frames that it rests on."""
    title, _, strategies = METRICS[metric]
    header = [f"{title}, {strategy}" for strategy in strategies]
    if metric == "steering_mse":
        header += [f"Frames of the MSE, {strategy}" for strategy in strategies]

    def cells(run: str, iteration: int) -> list[str]:
        found = [estimates(experiment, metric, run, iteration, each) for each in strategies]
        if metric == "steering_mse":
            found += [_frames(experiment, run, iteration, each) for each in strategies]
        return [" / ".join(pair) for pair in found]

    return _table(experiment, header, cells)


def cost(experiment: Experiment) -> str:
    header = ["Queries so far", "Frames driven so far", "Frames trained on"]
    return _table(
        experiment,
        header,
        lambda run, iteration: [count(round(mean)) for mean in spent(experiment, run, iteration)],
    )


def _table(
    experiment: Experiment, header: list[str], cells: Callable[[str, int], list[str]]
) -> str:
    """A row for each run and iteration."""
    rows = [
        [RUNS[run], str(iteration), *cells(run, iteration)]
        for run in experiment.runs
        for iteration in experiment.iterations(run)
    ]
    return table(["Run", "Iteration", *header], rows)


def estimates(
    experiment: Experiment, metric: str, run: str, iteration: int, strategy: Strategy
) -> list[str]:
    """Without and with traffic, each with its interval."""
    form = METRICS[metric][1]
    cells = [Cell(run, (iteration,), strategy, (where,)) for where in CONDITIONS]
    found = [estimate(experiment, metric, cell) for cell in cells]
    return [
        f"{form(one.value)} [{form(one.low)}, {form(one.high)}]" if one else NOTHING
        for one in found
    ]


def _frames(experiment: Experiment, run: str, iteration: int, strategy: Strategy) -> list[str]:
    """Frames that the primary drove, without and with traffic."""
    steps = experiment.of(run, iteration)
    drives = [[d for step in steps for d in drives_of(step, strategy, c)] for c in CONDITIONS]
    return [count(sum(drive.primary_frames for drive in each)) for each in drives]


def spent(experiment: Experiment, run: str, iteration: int) -> list[float]:
    """Queries and frames driven in the loop so far, frames trained on: means over the seeds."""
    rows = []
    for step in experiment.of(run, iteration):
        loop = [experiment.steps[step.seed, run, i].ledger for i in range(1, iteration + 1)]
        driven = sum(each.frames_driven for each in loop)
        rows.append((sum(each.queries for each in loop), driven, step.ledger.frames_trained))
    return [fmean(column) for column in zip(*rows, strict=True)]


def thresholds(found: Mapping[float, Experiment]) -> str:
    """The supervised primary under the safe strategy, a row for each tau."""
    if not found:
        return "There are no drives with safety policies of other tau."
    rows = []
    for tau, experiment in found.items():
        shares = [step.held_out.share_unsafe for step in experiment.of(RUN, 0)]
        known = [each for each in shares if each is not None]
        cells = [" / ".join(estimates(experiment, metric, RUN, 0, SAFE)) for metric in METRICS]
        seeds = ", ".join(map(str, experiment.seeds))
        rows.append([f"{tau:g}", seeds, share(fmean(known) if known else None), *cells])
    header = ["tau", "Seeds", "Truly unsafe", *(title for title, _, _ in METRICS.values())]
    return (
        "The supervised primary under the safe strategy, with safety policies of several tau. "
        "Truly unsafe is the share of the held-out frames of D_safe with a deviation above tau."
        f"\n\n{table(header, rows)}"
    )


def drives_of(step: Step, strategy: Strategy, where: str) -> list[Outcome]:
    return [d for d in step.drives if (d.strategy, condition(d)) == (strategy, where)]
