"""The paper's Fig. 2: the errors of a primary, and what share of them tau calls safe."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.registry import MEASURES
from stages import options


def errors(
    primary: options.Primary,
    trained: Annotated[Path, typer.Argument(help="What it was trained on: D_0.")],
    held_out: Annotated[Path, typer.Argument(help="Drives like these that it never saw.")],
    tau: Annotated[float, typer.Option(min=1e-9, help="The threshold on the deviation.")],
    measure: Annotated[
        str, typer.Option(help=f"What deviates: {', '.join(MEASURES)}, or module:function.")
    ],
    share: Annotated[
        float,
        typer.Option(
            min=1e-9, max=1, help="Which tau would make so many held-out frames safe; 0.777."
        ),
    ],
    figure: Annotated[Path, typer.Option(help="Where to draw the histograms (PNG).")],
    metrics: options.Metrics,
    device: options.Device = "cpu",
) -> None:
    """Show how a primary's errors lie around tau (Figure 2)."""
    from pipeline.data.dataset import Dataset
    from pipeline.evaluation.errors import error_histogram, error_summary
    from pipeline.evaluation.writing import write_metrics
    from pipeline.inspection.canvas import png
    from pipeline.learning.labels import LabelRule, threshold_for_share
    from pipeline.learning.safety import judge
    from pipeline.output import check_place, write_file
    from pipeline.policies.computing import find_device
    from pipeline.policies.loading import load_primary
    from pipeline.policies.measures import half_range

    check_place(figure, metrics)
    network = load_primary(primary, device=find_device(device))
    datasets = {"trained on": Dataset.open(trained), "held out": Dataset.open(held_out)}
    half_ranges = half_range(datasets["trained on"].features["action"])
    rule = LabelRule(measure, 0.0, "last", half_ranges)
    deviations = {
        name: judge(network, dataset, rule=rule).deviation for name, dataset in datasets.items()
    }
    summaries = {name: error_summary(found, tau) for name, found in deviations.items()}
    summaries["held out"]["tau_for_share"] = threshold_for_share(deviations["held out"], share)
    write_file(figure, png(error_histogram(deviations, tau, measure)))
    write_metrics(
        metrics,
        {
            "tau": tau,
            "share": share,
            **{name.replace(" ", "_"): summary for name, summary in summaries.items()},
        },
    )
    told = "; ".join(f"{name}: {options.figures(found)}" for name, found in summaries.items())
    typer.echo(f"{metrics}: {told} (for a share of {share:g})")
