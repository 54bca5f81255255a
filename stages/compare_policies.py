"""See two policies side by side: the same road, start and traffic, driven by each."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def compare_policies(
    primary_a: Annotated[Path, typer.Argument(help="A primary policy ...")],
    safety_a: Annotated[Path, typer.Argument(help="... and its safety policy.")],
    primary_b: Annotated[Path, typer.Argument(help="Another primary policy ...")],
    safety_b: Annotated[Path, typer.Argument(help="... and its safety policy.")],
    track: options.Track,
    traffic: options.Traffic,
    strategy: options.Strategy,
    seconds: options.Seconds,
    seed: options.Seed,
    record_every: options.RecordEvery = 3,
    cut: options.Cut = None,
    device: options.Device = "cpu",
    save: options.Save = None,
    web: options.Web = False,
) -> None:
    """Let two policies drive the same road, in Rerun.

    From the same start, among the same cars.
    """
    from pipeline.driving.task import Driving
    from pipeline.driving.tracks import make_track
    from pipeline.inspection.footage import Footage
    from pipeline.inspection.live import Tally, watched
    from pipeline.inspection.pairs import Pair
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_pair
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.plans import Plan
    from pipeline.rollout.strategies import parse_driving

    how, computes = parse_driving(strategy), find_device(device)
    task = Driving(
        tracks=track,
        traffic=traffic,
        record_every=record_every,
        seconds=seconds,
    )
    sides = [
        (Driver.load(primary, safety, device=computes), Judgement.read(safety, cut))
        for primary, safety in ((primary_a, safety_a), (primary_b, safety_b))
    ]
    fps = task.fps
    with options.rerun_sink(save, web, pair_blueprint(fps)) as sink:
        drives, tallies = [], []
        with options.progress("driving", 2 * seconds) as advance_to:
            for number, (driver, judgement) in enumerate(sides):
                frames, tally = [], Tally()
                plan = Plan(task, track, judgement.rule(how), (seed,))
                for world, footage in watched(plan, driver, judgement):
                    tally.add(world, footage)
                    frames.append(footage)
                    advance_to(number * seconds + len(frames) / fps)
                drives.append(Footage.joined(frames))
                tallies.append(tally)
        for name, tally in zip(
            (f"a, {primary_a.name}", f"b, {primary_b.name}"), tallies, strict=True
        ):
            typer.echo(f"{name}: {tally}")
        pair = Pair(
            f"{strategy}, {plan.description}, seed {seed}: a is {primary_a.name}, b is {primary_b.name}",
            f"{track}/{strategy}/{seed}/{primary_a.name}/{primary_b.name}",
            make_track(track),
            drives[0],
            drives[1],
            (sides[0][1], sides[1][1]),
        )
        log_pair(pair, sink.connect, fps=fps)
