"""Show a drive as a film: the track from above, what the car sees, and who drives."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options

if TYPE_CHECKING:
    from pipeline.task import Task

app = typer.Typer()


@app.command()
def film(
    primary: options.Primary,
    task: "Task",
    strategy: options.Strategy,
    show_every: Annotated[int, typer.Option(min=1, help="Frames to a picture of the film.")],
    output: Annotated[Path, typer.Option(help="The film to write (GIF). It must not exist.")],
    seed: options.Seed,
    safety: options.SafetyIfAny = None,
    cut: options.Cut = None,
    device: options.Device = "cpu",
) -> None:
    """Drive, and write a film of it (GIF).

    Ten pictures a second.
    """
    from pipeline.inspection.drawn import track_to_draw
    from pipeline.inspection.film import gif, shoot
    from pipeline.output import check_place, write_file
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement, rule_of
    from pipeline.rollout.plans import SEED_STREAMS, Plan
    from pipeline.rollout.strategies import parse_driving

    check_place(output)
    if output.suffix != ".gif":
        raise ValueError(f"{output}: expected a name that ends in .gif")
    track = track_to_draw(task)
    driver = Driver.load(primary, safety, device=find_device(device))
    rule = rule_of(parse_driving(strategy), Judgement.read(safety, cut) if safety else None)
    plan = Plan(task, track.name, rule, (seed, SEED_STREAMS["film"]))
    pictures = []
    with options.progress("driving", 1) as advance_to:
        for number, (picture, tally) in enumerate(shoot(plan, driver)):
            if number % show_every == 0:
                pictures.append(picture)
            advance_to(tally.done)
    write_file(output, gif(pictures, milliseconds=100))
    typer.echo(f"{output}: {len(pictures)} pictures; {tally}")
