"""Line 8 of Algorithm 1: D_i is D_{i-1} and what was selected."""

from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def merge(
    before: Annotated[options.Path, typer.Argument(help="D_{i-1}.")],
    selected: Annotated[options.Path, typer.Argument(help="What was selected of D'.")],
    output: options.Output,
) -> None:
    """Merge what was selected into the aggregate (line 8)."""
    from pipeline.data.merging import merge as merge_datasets

    typer.echo(merge_datasets([before, selected], output))
