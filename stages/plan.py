"""Unroll what an experiment compares into the loops of dvc.yaml."""

from pathlib import Path

import typer

from stages import options
from stages.parameters import read


def plan(
    params: options.Params = Path("params.yaml"),
    loops: options.Loops = Path("loops.yaml"),
    pipeline: options.Pipeline = Path("dvc.yaml"),
) -> None:
    """Write the pipeline's loops, from the runs.

    Once all names in the parameters are known.
    """
    from pipeline.loops import render
    from pipeline.output import write_file

    comparison = read(params, pipeline)
    write_file(loops, render(comparison).encode())
    typer.echo(f"{loops}: {', '.join(comparison.runs)}")
