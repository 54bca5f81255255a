"""Show a drive as a film: the track from above, what the car sees, and who drives."""

from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def film(
    primary: options.Primary,
    safety: options.Safety,
    output: options.Output,
    track: options.Track,
    traffic: options.Traffic,
    strategy: options.Strategy,
    laps: Annotated[float, typer.Option(min=0.01, help="Most laps to drive.")],
    seconds: options.Seconds,
    record_every: options.RecordEvery,
    show_every: Annotated[int, typer.Option(min=1, help="Frames to a picture of the film.")],
    seed: options.Seed,
    cut: options.Cut = None,
    device: options.Device = "cpu",
) -> None:
    """Drive, and write a film of it (GIF).

    Ten pictures a second.
    """
    from pipeline.driving.task import Driving
    from pipeline.inspection.film import gif, shoot
    from pipeline.output import check_place, write_file
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.plans import SEED_STREAMS, Plan
    from pipeline.rollout.strategies import parse_driving

    check_place(output)
    if output.suffix != ".gif":
        raise ValueError(f"{output}: expected a name that ends in .gif")
    driver = Driver.load(primary, safety, device=find_device(device))
    task = Driving(
        tracks=track,
        traffic=traffic,
        record_every=record_every,
        laps=laps,
        seconds=seconds,
    )
    rule = Judgement.read(safety, cut).rule(parse_driving(strategy))
    plan = Plan(task, track, rule, (seed, SEED_STREAMS["film"]))
    pictures = []
    with options.progress("driving", laps) as advance_to:
        for number, (picture, driven) in enumerate(shoot(plan, driver)):
            if number % show_every == 0:
                pictures.append(picture)
            advance_to(driven)
    write_file(output, gif(pictures, milliseconds=100))
    typer.echo(f"{output}: {len(pictures)} pictures, {driven:.2f} laps")
