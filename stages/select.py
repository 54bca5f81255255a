"""Line 7 of Algorithm 1: keep of D' what the reference was asked about."""

from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def select(
    raw: options.Dataset,
    output: options.Output,
    before: Annotated[
        float, typer.Option(min=0, help="Keep so much before each takeover, too, as context [s].")
    ] = 0,
    after: Annotated[float, typer.Option(min=0, help="And so much after it [s].")] = 0,
) -> None:
    """Select what the reference was asked about (line 7)."""
    from pipeline.data.dataset import Dataset
    from pipeline.data.selecting import select as keep_asked

    dataset = Dataset.open(raw)
    summary = keep_asked(dataset, output, before=before, after=after)
    if not dataset.has("queried"):
        typer.echo(f"{raw}: nobody wrote down what was queried, intervention stands for it")
    if summary.frames == 0:
        typer.echo(f"{raw}: the reference was asked nothing, so there is nothing to learn from it")
    if before or after:
        context = summary.frames - summary.queries
        typer.echo(f"{output}: {context} frames are context, no labels: `queried` is false there")
    typer.echo(summary)
