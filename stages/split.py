"""In the place of D_safe (Sec. 3.1, footnote): episodes of D_0 that are set aside from pi_0."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def split(
    dataset: options.Dataset,
    output: options.Output,
    aside: Annotated[Path, typer.Argument(help="Where to write what is set aside, likewise.")],
    share: Annotated[
        float, typer.Option(min=0, max=1, help="Share of the episodes to set aside.")
    ] = 0.2,
    seed: options.Seed = 0,
) -> None:
    """Set episodes aside, as a D_safe (Section 3.1).

    A primary learns from the others; its safety policy from these, as from D_safe.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.data.selecting import split as split_dataset

    for summary in split_dataset(Dataset.open(dataset), output, aside, share, seed):
        typer.echo(summary)
