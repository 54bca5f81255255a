"""DAgger's choice of what to train on (Sec. 4.2): a uniform sample of what was collected."""

from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def sample(
    raw: options.Dataset,
    output: options.Output,
    frames: Annotated[int, typer.Option(min=1, help="How many frames to keep.")],
    seed: options.Seed,
) -> None:
    """Keep a uniform sample of frames: DAgger (Section 4.2)."""
    import numpy as np

    from pipeline.data.reading import check_dataset, read_columns, read_episodes
    from pipeline.data.selecting import sample_frames
    from pipeline.data.writing import write_dataset

    record_every = check_dataset(raw)
    total = len(read_columns(raw, [])["frame_index"])
    rng = np.random.default_rng(seed)
    kept = sample_frames(read_episodes(raw), total, frames, rng)
    typer.echo(write_dataset(output, kept, record_every=record_every))
