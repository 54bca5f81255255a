"""Keep what an experiment compares beside what comes out, for the report."""

from pathlib import Path

import typer

from stages import options
from stages.parameters import read


def runs(
    params: options.Params,
    loops: options.Loops,
    metrics: options.Metrics,
    pipeline: options.Pipeline = Path("dvc.yaml"),
) -> None:
    """Keep what the runs are, for the report.

    And see that the loops of the pipeline are theirs, and all names in the parameters known.
    """
    from pipeline.loops import render
    from pipeline.output import check_place, write_file

    check_place(metrics)
    comparison = read(params, pipeline)
    if not loops.is_file() or loops.read_text() != render(comparison):
        raise ValueError(f"{loops}: not what {params} says, expected that of `safedagger plan`")
    text = comparison.model_dump_json(exclude_defaults=True, indent=1)
    write_file(metrics, f"{text}\n".encode())
    typer.echo(f"{metrics}: {', '.join(comparison.runs)}")
