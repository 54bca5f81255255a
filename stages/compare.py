"""Compare the training strategies (Sec. 5).

Reads the metrics of every seed and run; writes the report of the comparison as markdown, and its
figures.
"""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()

TITLES = {
    "strategies": "Training strategies: driving over the iterations (the paper's Fig. 3)",
    "strategies_takeover": "Training strategies: takeover, safe strategy (the paper's Fig. 4)",
    "strategies_cost": "Training strategies: naive laps against what they cost",
    "variants": "Variants of SafeDAgger: driving over the iterations",
    "variants_takeover": "Variants of SafeDAgger: takeover, safe strategy",
    "variants_cost": "Variants of SafeDAgger: naive laps against what they cost",
    "optimal": "The learned safety policies beside the optimal one (Eq. 2)",
}
"""Of each figure, by its name."""


@app.command()
def compare(
    metrics: Annotated[Path, typer.Option(help="Folder of seed_<n>/drives_<run>_<i>.csv, ...")],
    output: Annotated[Path, typer.Option(help="The report to write, markdown.")],
    figures: Annotated[Path, typer.Option(help="Folder for the report's figures, PNG.")],
) -> None:
    """Write the report of a comparison: verdicts on the paper's claims, figures, every number."""
    from pipeline.evaluation.comparison_figures import (
        TRAINING,
        VARIANTS,
        cost,
        driving,
        optimal,
        takeover,
    )
    from pipeline.evaluation.comparison_report import render_comparison
    from pipeline.evaluation.experiment import read_experiment
    from pipeline.evaluation.threshold import read_thresholds
    from pipeline.evaluation.writing import write_file
    from pipeline.inspection.canvas import png
    from pipeline.output import refuse_existing

    paths = {name: figures / f"{name}.png" for name in TITLES}
    for path in (output, *paths.values()):
        refuse_existing(path)

    experiment = read_experiment(metrics)
    thresholds = read_thresholds(metrics)
    variants = VARIANTS if set(VARIANTS[1:]) & set(experiment.runs) else ()
    drawn = {
        "strategies": driving(experiment, TRAINING),
        "strategies_takeover": takeover(experiment, TRAINING),
        "strategies_cost": cost(experiment, TRAINING),
        "variants": driving(experiment, variants),
        "variants_takeover": takeover(experiment, variants),
        "variants_cost": cost(experiment, variants),
        "optimal": optimal(experiment),
    }
    pictures = {name: png(figure) for name, figure in drawn.items() if figure}
    places = {TITLES[name]: options.seen_from(output, paths[name]) for name in pictures}
    text = render_comparison(experiment, thresholds, places)

    for name, picture in pictures.items():
        write_file(paths[name], picture)
    write_file(output, text.encode())
    typer.echo(f"{output}: {len(experiment.steps)} steps, {len(pictures)} figures in {figures}")
