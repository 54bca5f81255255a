"""Show what has come out so far, a line a step."""

from pathlib import Path
from typing import Annotated

import typer


def results(
    metrics: Annotated[
        Path, typer.Argument(help="Folder of seed_<n>/drives_<run>_<i>.csv, ...")
    ] = Path("cards/metrics"),
) -> None:
    """Show what has come out, a line a step."""
    from rich.console import Console
    from rich.table import Table

    from pipeline.evaluation.reading import read_experiment
    from pipeline.report.overview import HEADER, overview

    experiment = read_experiment(metrics)
    shown = Table(*HEADER, caption="Pairs are without / with traffic.", box=None, pad_edge=False)
    for row in overview(experiment):
        shown.add_row(*row)
    console = Console()
    # in a file or a pipe, as wide as it is
    Console(width=None if console.is_terminal else 200).print(shown)
    for line in experiment.left_out:
        typer.echo(f"Left out: {line}")
