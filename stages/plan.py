"""Unroll what an experiment compares into the loops of dvc.yaml."""

from pathlib import Path

import typer

from stages import options

app = typer.Typer()


@app.command()
def plan(
    params: options.Params = Path("params.yaml"), loops: options.Loops = Path("loops.yaml")
) -> None:
    """Write the pipeline's loops, from the runs."""
    from pipeline.output import write_file
    from pipeline.runs import Comparison, read_params, render

    comparison = Comparison.of(read_params(params))
    write_file(loops, render(comparison).encode())
    typer.echo(f"{loops}: {', '.join(comparison.runs)}")
