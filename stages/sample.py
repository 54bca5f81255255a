"""DAgger's choice of what to train on (Sec. 4.2): a uniform sample of what was collected."""

from typing import Annotated

import typer

from stages import options


def sample(
    raw: options.Dataset,
    output: options.Output,
    frames: Annotated[int, typer.Option(min=1, help="How many frames to keep.")],
    seed: options.Seed,
) -> None:
    """Keep a uniform sample of frames: DAgger (Section 4.2)."""
    from pipeline.data.dataset import Dataset
    from pipeline.data.selecting import sample as keep_sample

    typer.echo(keep_sample(Dataset.open(raw), output, frames, seed))
