"""Lines 1 and 2 of Algorithm 1: collect D_0, and D_safe, with the reference policy.

And what the supervised strategy trains on in later iterations (Sec. 4.4).
"""

from typing import Annotated, Literal

import typer

from stages import options
from stages.recording import keep


def collect(
    context: typer.Context,
    output: options.Output,
    task: options.Task,
    episodes: Annotated[
        int, typer.Option(min=1, help="Drives, spread evenly over the scenarios.")
    ] = 70,
    purpose: Annotated[
        Literal["D_0", "D_safe", "D_held", "supervised"],
        typer.Option(help="Which random numbers to draw: no two purposes share any."),
    ] = "D_0",
    iteration: Annotated[int, typer.Option(min=0, help="The iteration that this is for.")] = 0,
    seed: options.Seed = 0,
    workers: options.Workers = None,
) -> None:
    """Collect a dataset with the reference (lines 1, 2).

    Also what supervised learning trains on in later iterations.
    """
    from pipeline.data.lineage import Recipe
    from pipeline.rollout.plans import stream
    from pipeline.rollout.recording import record_all
    from pipeline.rollout.rules.reference import Reference

    drives = record_all(
        task,
        Reference(),
        None,
        range(episodes),
        seed=(seed, stream(purpose, iteration)),
        iteration=iteration,
        workers=workers,
        measure=False,
    )

    recipe = Recipe(purpose, options.arguments(context))
    typer.echo(
        keep(drives, output, recipe, task, what="collecting", total=episodes, count=lambda drive: 1)
    )
