"""Line 7 of Algorithm 1: keep of D' what the reference drove."""

from typing import Annotated, Literal

import typer

from stages import options


def select(
    raw: options.Dataset,
    output: options.Output,
    because: Annotated[
        Literal["drove", "audit", "mixture", "afterwards"],
        typer.Option(
            help="Why the reference was asked: what it drove is for the primary; audits are for the "
            "safety policy (train-safety --audits)."
        ),
    ] = "drove",
    before: Annotated[
        float, typer.Option(min=0, help="Keep so much before each takeover, too, as context [s].")
    ] = 0,
    after: Annotated[float, typer.Option(min=0, help="And so much after it [s].")] = 0,
) -> None:
    """Select what the reference drove (line 7).

    Or, apart, what it was asked about for another reason.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.data.schema import Asked
    from pipeline.data.selecting import select as keep_asked

    dataset = Dataset.open(raw)
    summary = keep_asked(dataset, output, Asked[because.upper()], before=before, after=after)
    if not dataset.has("queried"):
        typer.echo(f"{raw}: nobody wrote down what was queried, intervention stands for it")
    others = int(dataset.column("queried").sum()) - summary.queries
    if others:
        typer.echo(f"{raw}: {others} frames that were asked about for another reason are left out")
    if summary.frames == 0:
        typer.echo(
            f"{raw}: the reference was asked nothing so, and there is nothing to learn from it"
        )
    if before or after:
        context = summary.frames - summary.queries
        typer.echo(f"{output}: {context} frames are context, no labels: `queried` is false there")
    typer.echo(summary)
