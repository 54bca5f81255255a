"""Line 8 of Algorithm 1: D_i is D_{i-1} and what was selected."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def merge(
    parts: Annotated[
        list[Path], typer.Argument(help="D_{i-1}, and what was selected of D'; or any two or more.")
    ],
    output: options.Output,
) -> None:
    """Merge what was selected into the aggregate (line 8)."""
    from pipeline.data.dataset import Dataset
    from pipeline.data.labels import told
    from pipeline.data.merging import filled
    from pipeline.data.merging import merge as merge_datasets

    datasets = [Dataset.open(path) for path in parts]
    summary = merge_datasets(datasets, output)
    for path, names in filled(datasets).items():
        typer.echo(f"{path}: has no {', '.join(names)}: what is known of them stands in {output}")
    for line in (line for dataset in datasets for line in told(dataset)):
        typer.echo(line)
    if len(datasets[0]) == summary.frames:
        typer.echo(f"{output}: the same frames as {parts[0]}, there was nothing to add")
    typer.echo(summary)
