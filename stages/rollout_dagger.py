"""DAgger's line 6 (Sec. 2.6): collect D' with a mixture of reference and primary, all labelled."""

from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options

if TYPE_CHECKING:
    from pipeline.data.schema import Episode

app = typer.Typer()


@app.command()
def rollout_dagger(
    context: typer.Context,
    primary: options.Primary,
    output: options.Output,
    tracks: options.Tracks,
    traffic: options.Traffic,
    beta: Annotated[
        float, typer.Option(min=0, max=1, help="Probability that the reference drives a frame.")
    ],
    frames: Annotated[int, typer.Option(min=1, help="How many frames to drive: each is a query.")],
    seconds: options.Seconds,
    offset_spread: options.OffsetSpread,
    angle_spread: options.AngleSpread,
    record_every: options.RecordEvery,
    iteration: Annotated[int, typer.Option(min=1, help="The iteration that this is for.")],
    seed: options.Seed,
    workers: options.Workers,
) -> None:
    """Drive with DAgger's mixture, all labelled (Section 2.6)."""
    from pipeline.data.lineage import Recipe
    from pipeline.data.writing import write_dataset
    from pipeline.driving.features import ROBOT_TYPE, check_record_every
    from pipeline.output import check_place
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import policy_lineage
    from pipeline.rollout.recording import SEED_STREAMS, Drive, record_all, until_queries
    from pipeline.rollout.strategies import Rule, Strategy

    check_place(output)
    names = options.names(tracks)
    plan = Drive(
        track=names[0],
        traffic=traffic,
        spread=(offset_spread, angle_spread),
        seed=(seed, SEED_STREAMS["rollout"] + iteration),
        rule=Rule(Strategy.MIXTURE, beta=beta),
        record_every=record_every,
        seconds=seconds,
    )
    driver = Driver.load(primary)
    drives = record_all(plan, names, count(), driver, iteration=iteration, workers=workers)

    def driven() -> Iterator["Episode"]:
        asked = 0
        with options.progress("frames", frames) as advance_to:
            for recording in until_queries(drives, frames, frames):
                yield recording.episode
                asked += recording.queries
                advance_to(asked)

    recipe = Recipe("rollout-dagger", options.arguments(context), [policy_lineage(primary)])
    fps = check_record_every(record_every)
    typer.echo(write_dataset(output, driven(), recipe, fps=fps, robot=ROBOT_TYPE))
