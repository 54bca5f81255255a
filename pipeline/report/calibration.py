"""How probable the safety policies call unsafe, and how often it is, as a figure of the report."""

from collections import defaultdict
from collections.abc import Iterable, Sequence

from matplotlib.figure import Figure

from pipeline.evaluation.drives import among
from pipeline.evaluation.experiment import HELD_OUT, ROLLOUT, Experiment
from pipeline.evaluation.quality import draw_calibration
from pipeline.inspection.canvas import new_figure, styled
from pipeline.metric import BINS

PANELS = {
    HELD_OUT: "held out of D_safe, which the reference drove",
    ROLLOUT: "the next rollout, which it decided about",
}


def calibration(experiment: Experiment) -> Figure | None:
    """SafeDAgger's, a line for each iteration, over the frames of all seeds; None where it was not
    measured.
    """
    judged = among(experiment.quality, run=experiment.ours)
    judged = judged[judged.calibration.map(len) > 0]
    if judged.empty:
        return None
    with styled():
        figure = new_figure(9.0, 4.2)
        for number, (on, title) in enumerate(PANELS.items(), 1):
            axes = figure.add_subplot(1, len(PANELS), number)
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
