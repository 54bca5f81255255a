"""DAgger's line 6 (Sec. 2.6): collect D' with a mixture of reference and primary, and ask about it."""

import sys
from itertools import count
from typing import Annotated

import typer

from stages import options
from stages.recording import keep


def rollout_dagger(
    context: typer.Context,
    primary: options.Primary,
    output: options.Output,
    task: options.Task,
    frames: Annotated[
        int,
        typer.Option(
            min=1, help="How many frames to be asked about, all that are driven by default."
        ),
    ],
    beta: Annotated[
        float, typer.Option(min=0, max=1, help="Probability that the reference drives a frame.")
    ] = 0.0,
    ask: Annotated[
        float,
        typer.Option(
            min=0.01, max=1, help="Share of what the primary drives to be asked about, at random."
        ),
    ] = 1.0,
    iteration: options.Iteration = 1,
    seed: options.Seed = 0,
    workers: options.Workers = None,
    hold: options.Hold = None,
    device: options.Device = "cpu",
) -> None:
    """Drive with DAgger's mixture, and ask (Section 2.6)."""
    from pipeline.data.lineage import Recipe
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import policy_lineage
    from pipeline.rollout.plans import stream
    from pipeline.rollout.recording import record_all, until_queries
    from pipeline.rollout.rules.mixture import Mixture

    drives = record_all(
        task,
        Mixture(beta, ask),
        Driver.load(primary, hold=hold or 1, device=find_device(device)),
        count(),
        seed=(seed, stream("rollout", iteration)),
        iteration=iteration,
        workers=workers,
        measure=False,
    )

    recipe = Recipe("rollout-dagger", options.arguments(context), [policy_lineage(primary)])
    driven = until_queries(drives, frames, sys.maxsize)
    typer.echo(keep(driven, output, recipe, task, what="frames", total=frames))
