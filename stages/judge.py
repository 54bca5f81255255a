"""How well a safety policy tells unsafe frames, where it counts: in any drives that are labelled."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def judge(
    primary: options.Primary,
    safety: options.Safety,
    datasets: Annotated[
        list[Path], typer.Argument(help="Datasets: their frames with a label are measured.")
    ],
    where: Annotated[
        list[str] | None,
        typer.Option(
            help="Frames to measure apart, as a condition on the named numbers of the columns and on "
            "since_handover [s]: 'distance_ahead < 20'. Can be given several times."
        ),
    ] = None,
    tau: Annotated[
        float | None,
        typer.Option(min=0, help="Unsafe is above it; by default that of the safety policy."),
    ] = None,
    cut: options.Cut = None,
    known: Annotated[
        list[float] | None,
        typer.Option(
            min=0,
            help="Also the AUROC of whoever knew the reference's action but for a normal error of this "
            "standard deviation, half the range being 1. Can be given several times.",
        ),
    ] = None,
    seed: options.Seed = 0,
    metrics: options.MetricsIfAny = None,
    figure: Annotated[
        Path | None,
        typer.Option(help="Where to draw predicted against observed (PNG). It must not exist."),
    ] = None,
    device: options.Device = "cpu",
) -> None:
    """Measure a safety policy on labelled frames.

    With `--audit 1`, each frame of a rollout has a label.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.evaluation.quality import calibration_picture, quality_table
    from pipeline.evaluation.wording import written
    from pipeline.evaluation.writing import write_metrics
    from pipeline.inspection.canvas import png
    from pipeline.learning import judging
    from pipeline.learning.labels import LabelRule
    from pipeline.metric import QUALITY
    from pipeline.output import check_place, write_file
    from pipeline.policies.computing import find_device
    from pipeline.policies.loading import load_pair, read_cut, read_labels

    check_place(metrics, figure)
    network, watching = load_pair(primary, safety, find_device(device))
    labels = read_labels(safety)
    rule, tau = LabelRule.of(labels), labels["tau"] if tau is None else tau
    cut = read_cut(safety) if cut is None else cut
    rows, bounds = [], []
    for path in datasets:
        frames = judging.look_at(network, watching, Dataset.open(path), rule)
        for name, here in judging.situations(frames, where or ()):
            found = judging.quality(frames, here, tau, cut)
            rows.append({"dataset": path.name, "situation": name, **found})
        for error in known or ():
            auroc = judging.auroc_if_known(frames, rule, tau, error, seed)
            bounds.append({"dataset": path.name, "error": error, "auroc": auroc})
    typer.echo(quality_table(rows))
    for bound in bounds:
        told = written(QUALITY["auroc"], bound["auroc"])
        typer.echo(f"{bound['dataset']}, known to within {bound['error']:g}: {told}")
    if figure:
        whole = [row for row in rows if row["situation"] == judging.ALL]
        write_file(figure, png(calibration_picture(whole)))
    if metrics:
        write_metrics(metrics, {"tau": tau, "cut": cut, "rows": rows, "bounds": bounds})
