"""An experiment in figures: what it has, with 95 % intervals; None where it has nothing."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import HELD_OUT, ROLLOUT, Experiment
from pipeline.evaluation.quality import draw_calibration
from pipeline.inspection.canvas import new_figure
from pipeline.metric import BINS, shown
from pipeline.report.looks import label
from pipeline.report.panels import Line, Panel, draw
from pipeline.rollout.strategies import Strategy

TITLES = {
    "strategies": "Training strategies: driving over the iterations (the paper's Fig. 3)",
    "strategies_takeover": "Training strategies: takeover, safe strategy (the paper's Fig. 4)",
    "strategies_cost": "Training strategies: naive laps against what they cost",
    "variants": "Variants of SafeDAgger: driving over the iterations",
    "variants_takeover": "Variants of SafeDAgger: takeover, safe strategy",
    "variants_cost": "Variants of SafeDAgger: naive laps against what they cost",
    "optimal": "The learned safety policies beside the optimal one (Eq. 2)",
    "calibration": "How probable the safety policies call unsafe, and how often it is",
}
"""Of each figure over the iterations, by its name."""
JUDGED_ON = {
    HELD_OUT: "held out of D_safe, which the reference drove",
    ROLLOUT: "the next rollout, which it decided about",
}
"""What a safety policy was judged on, in words."""


def over_the_iterations(experiment: Experiment) -> dict[str, Figure]:
    """Those of TITLES that have something to show."""
    strategies = experiment.strategies
    has_variants = ({*experiment.variants} - {experiment.ours}) & {*experiment.runs}
    variants = experiment.variants if has_variants else ()
    drawn = {
        "strategies": driving(experiment, strategies),
        "strategies_takeover": takeover(experiment, strategies),
        "strategies_cost": cost(experiment, strategies),
        "variants": driving(experiment, variants),
        "variants_takeover": takeover(experiment, variants),
        "variants_cost": cost(experiment, variants),
        "optimal": optimal(experiment),
        "calibration": calibration(experiment),
    }
    return {name: figure for name, figure in drawn.items() if figure}


def result(experiment: Experiment) -> Figure | None:
    """What the queries of the training strategies have bought, above all in traffic, and how long the
    reference drives.
    """
    runs = experiment.strategies
    naive = _panels(experiment, runs, Strategy.NAIVE, "laps", "queries")[::-1]
    safe = _panels(experiment, runs, Strategy.SAFE, "takeover")
    panels = [*(replace(panel, is_wide=True) for panel in naive[:1]), *naive[1:], *safe]
    return draw(experiment, panels, columns=3)


def driving(experiment: Experiment, runs: Sequence[str]) -> Figure | None:
    """As the paper's Fig. 3."""
    panels = [
        panel
        for strategy in (Strategy.NAIVE, Strategy.SAFE)
        for metric, told in shown(METRICS, "figures").items()
        if strategy in told.strategies
        for panel in _panels(experiment, runs, strategy, metric)
    ]
    return draw(experiment, panels, columns=3)


def takeover(experiment: Experiment, runs: Sequence[str]) -> Figure | None:
    """As the paper's Fig. 4: the share of the time that the reference drives."""
    panels = _panels(experiment, runs, Strategy.SAFE, "takeover")
    return draw(experiment, panels, columns=2)


def cost(experiment: Experiment, runs: Sequence[str]) -> Figure | None:
    """What the queries, and the frames trained on, have bought."""
    panels = [
        panel
        for place in ("queries", "frames_trained")
        for panel in _panels(experiment, runs, Strategy.NAIVE, "laps", place)
    ]
    return draw(experiment, panels, columns=2)


def optimal(experiment: Experiment) -> Figure | None:
    """The learned safety policies beside the optimal one; a row for each run whose loop has it."""
    compared = (Strategy.SAFE, Strategy.OPTIMAL)
    panels = [
        Panel(
            f"{experiment.title(run)}, {label(where)}",
            metric,
            [Line(run, strategy, where, key=strategy) for strategy in compared],
        )
        for run in experiment.runs
        if _has_optimal(experiment, run)
        for metric in ("takeover", "laps")
        for where in experiment.conditions
    ]
    return draw(experiment, panels, columns=2)


def calibration(experiment: Experiment) -> Figure | None:
    """SafeDAgger's, a line for each iteration, over the frames of all seeds; None where it was not
    measured.
    """
    judged = among(experiment.quality, run=experiment.ours)
    judged = judged[judged.calibration.map(len) > 0]
    if judged.empty:
        return None
    with new_figure(9.0, 4.2) as figure:
        for number, (on, title) in enumerate(JUDGED_ON.items(), 1):
            axes = figure.add_subplot(1, len(JUDGED_ON), number)
            rows = among(judged, judged_on=on).groupby("iteration").calibration
            draw_calibration(axes, {f"iteration {i}": pooled(bins) for i, bins in rows})
            axes.set_title(title)
    return figure


def pooled(measured: Iterable[Sequence[Sequence[float]]]) -> list[list[float]]:
    """The bins of several sets of frames as those of all their frames."""
    together = defaultdict(list)
    for predicted, observed, frames in (each for bins in measured for each in bins):
        together[min(int(BINS * round(predicted, 6)), BINS - 1)].append(
            (predicted, observed, frames)
        )
    found = []
    for _, bins in sorted(together.items()):
        many = sum(frames for *_, frames in bins)
        found.append([sum(each[of] * each[2] for each in bins) / many for of in (0, 1)] + [many])
    return found


def _has_optimal(experiment: Experiment, run: str) -> bool:
    """In its loop: iteration 0 may be another run's too."""
    return bool((experiment.among(run=run, strategy=Strategy.OPTIMAL).iteration > 0).any())


def _panels(
    experiment: Experiment,
    runs: Sequence[str],
    strategy: Strategy,
    metric: str,
    place: str = "iteration",
) -> list[Panel]:
    """In each condition, with a line for each run."""
    return [
        Panel(
            f"{strategy}, {label(where)}",
            metric,
            [Line(run, strategy, where, key=run) for run in runs],
            place,
        )
        for where in experiment.conditions
    ]
