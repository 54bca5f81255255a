"""The tables of the report: every metric with its interval, what it cost, how drives ended."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import pandas as pd

from pipeline.driving.metrics import KINDS, METRICS
from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.curves import success
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import HELD_OUT, ROLLOUT, Experiment, Tables, mean
from pipeline.evaluation.files import ErrorShares
from pipeline.evaluation.summary import measure
from pipeline.evaluation.wording import (
    FORMS,
    NOTHING,
    brief_interval,
    count,
    pair,
    share,
    table,
    written,
)
from pipeline.metric import COLLECTED, QUALITY, SPENT, Metric, shown
from pipeline.rollout.strategies import DRIVING, Strategy

NAIVE, SAFE, OPTIMAL = DRIVING
BY_TAU = ("laps", "damage_per_lap", "takeover", "switches_per_lap", "takeover_length")
"""metrics that are given for each tau"""
BY_TRACK = (("laps", NAIVE), ("laps", SAFE), ("damage_per_lap", NAIVE), ("takeover", SAFE))


def driving(experiment: Experiment, metric: str) -> str:
    """One metric under the strategies that were driven, and of the steering MSE the frames that it
    rests on.
    """
    driven = set(experiment.drives.strategy)
    told = METRICS[metric].strategies
    strategies = [strategy for strategy in DRIVING if strategy in told and strategy in driven]
    header = [f"{METRICS[metric].title}, {strategy}" for strategy in strategies]
    if metric == "steering_mse":
        header += [f"Frames of the MSE, {strategy}" for strategy in strategies]

    def cells(run: str, iteration: int) -> Iterator[str]:
        for strategy in strategies:
            yield pair(estimates(experiment, metric, run, iteration, strategy))
        for strategy in strategies if metric == "steering_mse" else ():
            here = experiment.among(run=run, iteration=iteration, strategy=strategy)
            yield pair(count(group.primary_frames.sum()) for group in _groups(experiment, here))

    return _by_iteration(experiment, experiment.runs, header, cells)


def reliability(relied_on: Experiment) -> str:
    """How far the primaries can be relied on alone, and on how many drives and seeds that rests."""
    titles = (METRICS[name].title for name in ("success", "failures"))
    header = ["Drives, seeds", *(f"{title}, naive" for title in titles)]
    return _by_iteration(relied_on, relied_on.runs, header, partial(relied_on_in, relied_on))


def relied_on_in(relied_on: Experiment, run: str, iteration: int) -> Iterator[str]:
    """How many drives and seeds there are, their successes, and their failures in a distance."""
    drives = relied_on.among(run=run, iteration=iteration)
    yield f"{len(drives)}, {drives.seed.nunique()}"
    yield successes(relied_on, run, iteration)
    yield pair(estimates(relied_on, "failures", run, iteration, NAIVE))


def successes(relied_on: Experiment, run: str, iteration: int) -> str:
    """In each condition, with its interval."""
    found = (success(relied_on, run, iteration, where) for where in relied_on.conditions)
    return pair(brief_interval(each, share) for each in found)


def cost(experiment: Experiment) -> str:
    """What the loop has cost so far, and what the reference labelled in all: means over the seeds."""
    return _so_far(experiment, SPENT)


def collecting(experiment: Experiment) -> str:
    """What the loop's drives took so far, and what became of them; empty where no ledger says so."""
    counted = experiment.ledgers.calls.notna().any()
    return _so_far(experiment, {**COLLECTED, **KINDS}) if counted else ""


def safety(experiment: Experiment) -> str:
    """How well the safety policies of SafeDAgger and its variants find the unsafe frames."""
    metrics = shown(QUALITY, "tables").values()

    def cells(run: str, iteration: int) -> Iterator[str]:
        here = among(experiment.quality, run=run, iteration=iteration)
        yield ", ".join(f"{tau:g}" for tau in sorted(set(here.tau)))
        for metric in metrics:
            found = [mean(here, metric, judged_on=judged) for judged in (HELD_OUT, ROLLOUT)]
            yield pair(written(metric, value) for value in found)

    runs = [run for run in experiment.runs if experiment.specs[run].is_watched]
    return _by_iteration(experiment, runs, ["tau", *(each.title for each in metrics)], cells)


def thresholds(found: Tables) -> str:
    """The supervised primary under the safe strategy, a row for each tau."""
    unsafe = QUALITY["share_unsafe"]
    rows = [
        [
            tau,
            ", ".join(map(str, found.seeds_of(tau, 0))),
            written(unsafe, mean(found.quality, unsafe, run=tau)),
            *(pair(estimates(found, metric, tau, 0, SAFE)) for metric in BY_TAU),
        ]
        for tau in sorted(set(found.drives.run), key=float)
    ]
    titles = [METRICS[metric].title for metric in BY_TAU]
    return table(["tau", "Seeds", unsafe.title, *titles], rows)


def errors(found: Mapping[int, ErrorShares]) -> str:
    """Which errors of the supervised primary are safe, a row for each seed."""
    rows = []
    for seed, each in sorted(found.items()):
        tau = each.held_out.tau_for_share
        asked = NOTHING if tau is None else f"{tau:.3g} ({share(each.share)})"
        safe = [share(of.share_safe) for of in (each.trained_on, each.held_out)]
        rows.append([str(seed), f"{each.tau:g}", *safe, asked])
    header = ["Seed", "tau", "Safe of D_0", "Safe of those held out", "tau for the paper's share"]
    return table(header, rows)


def by_track(experiment: Experiment) -> str:
    """A row for each run and track, after the run's last iteration, over all its seeds."""
    rows = [
        [
            experiment.title(run),
            str(track),
            *(measured(experiment, drives, *each) for each in BY_TRACK),
        ]
        for run in experiment.runs
        for track, drives in experiment.among(
            run=run, iteration=experiment.iterations(run)[-1]
        ).groupby("scenario")
    ]
    header = [f"{METRICS[metric].title}, {strategy}" for metric, strategy in BY_TRACK]
    return table(["Run", "Track", *header], rows, words=2)


def endings(experiment: Experiment) -> Iterator[str]:
    """How drives ended that did not do all laps, in counts: a table for each driving strategy that
    has such drives; a sentence for the others.
    """
    for strategy in DRIVING:
        drives = experiment.among(strategy=strategy)
        header = ["Left the road", "Stopped on the road"]
        titles = [f"{title}, {strategy}" for title in header]
        rows = [
            [
                experiment.title(run),
                str(iteration),
                *(
                    pair(_part(ended(group)) for group in _groups(experiment, here))
                    for ended in (left_the_road, stopped_short)
                ),
            ]
            for run in experiment.runs
            for iteration in experiment.iterations(run)
            if failed(here := among(drives, run=run, iteration=iteration)).any()
        ]
        if rows:
            yield table(["Run", "Iteration", *titles], rows)
        elif not drives.empty:
            yield f"All {strategy} drives did {most_laps(experiment)} laps."


def left_the_road(drives: pd.DataFrame) -> "pd.Series[bool]":
    """Which of them ended beside the road."""
    return drives.off_road > 0


def stopped_short(drives: pd.DataFrame) -> "pd.Series[bool]":
    """Which ended on the road before all laps were done: stood still, or out of time."""
    return (drives.laps < drives["task.laps"]) & ~left_the_road(drives)


def failed(drives: pd.DataFrame) -> "pd.Series[bool]":
    """Which did not do all laps."""
    return left_the_road(drives) | stopped_short(drives)


def most_laps(experiment: Tables) -> str:
    """After so many a drive is over."""
    return f"{experiment.most(METRICS['laps']):g}"


def estimates(
    experiment: Tables, metric: str, run: str, iteration: int, strategy: Strategy
) -> list[str]:
    """In each condition, with its interval."""
    form = FORMS[METRICS[metric].form].value
    cells = [Cell(run, (iteration,), strategy, (where,)) for where in experiment.conditions]
    return [brief_interval(estimate(experiment, metric, cell), form) for cell in cells]


def measured(experiment: Tables, drives: pd.DataFrame, metric: str, strategy: Strategy) -> str:
    """Of some drives, in each condition; NOTHING where nobody drove."""
    told = {metric: METRICS[metric]}
    form = FORMS[told[metric].form].value
    groups = _groups(experiment, among(drives, strategy=strategy))
    return pair(NOTHING if each.empty else form(measure(each, told)[metric]) for each in groups)


def _groups(experiment: Tables, drives: pd.DataFrame) -> list[pd.DataFrame]:
    return [among(drives, condition=where) for where in experiment.conditions]


def _part(ended: "pd.Series[bool]") -> str:
    return f"{ended.sum()} of {len(ended)}" if len(ended) else NOTHING


def _so_far(experiment: Experiment, metrics: Mapping[str, Metric]) -> str:
    """Of the loop up to each iteration."""
    told = shown(metrics, "tables").values()

    def cells(run: str, iteration: int) -> Iterator[str]:
        for metric in told:
            yield written(metric, mean(experiment.spent, metric, run=run, iteration=iteration))

    return _by_iteration(experiment, experiment.runs, [each.title for each in told], cells)


def _by_iteration(
    experiment: Experiment,
    runs: Sequence[str],
    header: Sequence[str],
    cells: Callable[[str, int], Iterator[str]],
) -> str:
    """A row for each run and iteration."""
    rows = [
        [experiment.title(run), str(iteration), *cells(run, iteration)]
        for run in runs
        for iteration in experiment.iterations(run)
    ]
    return table(["Run", "Iteration", *header], rows)
