"""Line 7 of Algorithm 1: keep of D' what the safety policy called unsafe."""

import typer

from stages import options

app = typer.Typer()


@app.command()
def select(raw: options.Dataset, output: options.Output, cut: options.Cut) -> None:
    """Select the frames that were called unsafe (line 7)."""
    from pipeline.data.reading import check_dataset, read_episodes
    from pipeline.data.selecting import check_unsafe, select_unsafe
    from pipeline.data.writing import write_dataset

    record_every = check_dataset(raw)
    check_unsafe(raw, cut)
    typer.echo(
        write_dataset(output, select_unsafe(read_episodes(raw), cut), record_every=record_every)
    )
