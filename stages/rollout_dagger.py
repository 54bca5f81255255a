"""DAgger's line 6 (Sec. 2.6): collect D' with a mixture of reference and primary, all labelled."""

from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options

if TYPE_CHECKING:
    from pipeline.data.schema import Episode
    from pipeline.task import Task

app = typer.Typer()


@app.command()
@options.seam("task")
def rollout_dagger(
    context: typer.Context,
    primary: options.Primary,
    output: options.Output,
    task: "Task",
    beta: Annotated[
        float, typer.Option(min=0, max=1, help="Probability that the reference drives a frame.")
    ],
    frames: Annotated[int, typer.Option(min=1, help="How many frames to drive: each is a query.")],
    iteration: Annotated[int, typer.Option(min=1, help="The iteration that this is for.")],
    seed: options.Seed,
    workers: options.Workers,
) -> None:
    """Drive with DAgger's mixture, all labelled (Section 2.6)."""
    from pipeline.data.lineage import Recipe
    from pipeline.data.writing import write_dataset
    from pipeline.output import check_place
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import policy_lineage
    from pipeline.rollout.plans import SEED_STREAMS
    from pipeline.rollout.recording import record_all, until_queries
    from pipeline.rollout.rules.mixture import Mixture

    check_place(output)
    drives = record_all(
        task,
        Mixture(beta),
        Driver.load(primary),
        count(),
        seed=(seed, SEED_STREAMS["rollout"] + iteration),
        iteration=iteration,
        workers=workers,
        measure=False,
    )

    def driven() -> Iterator["Episode"]:
        asked = 0
        with options.progress("frames", frames) as advance_to:
            for recording in until_queries(drives, frames, frames):
                yield recording.episode
                asked += recording.queries
                advance_to(asked)

    recipe = Recipe("rollout-dagger", options.arguments(context), [policy_lineage(primary)])
    typer.echo(write_dataset(output, driven(), recipe, fps=task.fps, robot=task.robot))
