"""Lines 1 and 2 of Algorithm 1: collect D_0, and D_safe, with the reference policy.

And what the supervised strategy trains on in later iterations (Sec. 4.4).
"""

from collections.abc import Iterator
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options

if TYPE_CHECKING:
    from pipeline.data.schema import Episode

app = typer.Typer()


class Purpose(StrEnum):
    """What is collected."""

    d_0 = "D_0"
    d_safe = "D_safe"
    d_held = "D_held"
    supervised = "supervised"


@app.command()
def collect(
    context: typer.Context,
    output: options.Output,
    tracks: options.Tracks,
    traffic: options.Traffic,
    episodes: Annotated[int, typer.Option(min=1, help="Drives, spread evenly over the tracks.")],
    seconds: options.Seconds,
    offset_spread: options.OffsetSpread,
    angle_spread: options.AngleSpread,
    record_every: options.RecordEvery,
    purpose: Annotated[
        Purpose, typer.Option(help="Which random numbers to draw: no two purposes share any.")
    ],
    iteration: Annotated[int, typer.Option(min=0, help="The iteration that this is for.")],
    seed: options.Seed,
    workers: options.Workers,
) -> None:
    """Collect a dataset with the reference (lines 1, 2).

    Also what supervised learning trains on in later iterations.
    """
    from pipeline.data.lineage import Recipe
    from pipeline.data.writing import write_dataset
    from pipeline.driving.features import ROBOT_TYPE, check_record_every
    from pipeline.output import check_place
    from pipeline.rollout.recording import SEED_STREAMS, Drive, record_all
    from pipeline.rollout.strategies import Rule, Strategy

    check_place(output)
    names = options.names(tracks)
    plan = Drive(
        track=names[0],
        traffic=traffic,
        spread=(offset_spread, angle_spread),
        seed=(seed, SEED_STREAMS[purpose] + iteration),
        rule=Rule(Strategy.REFERENCE),
        record_every=record_every,
        seconds=seconds,
    )
    drives = record_all(plan, names, range(episodes), None, iteration=iteration, workers=workers)

    def driven() -> Iterator["Episode"]:
        with options.progress("collecting", episodes) as advance_to:
            for done, recording in enumerate(drives, 1):
                yield recording.episode
                advance_to(done)

    recipe = Recipe(purpose.value, options.arguments(context))
    fps = check_record_every(record_every)
    typer.echo(write_dataset(output, driven(), recipe, fps=fps, robot=ROBOT_TYPE))
