"""Watch a drive while it is driven: any policies, strategy and track."""

from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


class Driving(StrEnum):
    """Who drives."""

    naive = "naive"
    safe = "safe"
    optimal = "optimal"
    reference = "reference"


@app.command()
def watch(
    track: options.Track,
    traffic: options.Traffic,
    strategy: Annotated[Driving, typer.Option(help="Who drives. reference needs no policies.")],
    seconds: options.Seconds,
    seed: options.Seed,
    primary: Annotated[
        Path | None, typer.Argument(help="A primary policy, as train-primary writes it.")
    ] = None,
    safety: Annotated[
        Path | None, typer.Argument(help="Its safety policy, as train-safety writes it.")
    ] = None,
    record_every: options.RecordEvery = 3,
    cut: options.Cut = None,
    device: options.Device = "cpu",
    save: options.Save = None,
    web: options.Web = False,
) -> None:
    """Drive, and show it in Rerun meanwhile. Ctrl-C ends the drive."""
    from pipeline.driving.task import Driving as DrivingTask
    from pipeline.driving.tracks import make_track
    from pipeline.inspection.live import Tally, in_real_time, watched
    from pipeline.inspection.rerun_blueprints import live_blueprint
    from pipeline.inspection.rerun_camera import RAW
    from pipeline.inspection.rerun_log import drive_tracer, new_recording
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.plans import Plan
    from pipeline.rollout.rules.reference import Reference
    from pipeline.rollout.rules.rule import Rule
    from pipeline.rollout.strategies import Strategy

    computes, driver, judgement = find_device(device), None, None
    rule: Rule = Reference()
    if primary is not None and safety is not None:
        driver = Driver.load(primary, safety, device=computes)
        judgement = Judgement.read(safety, cut)
        rule = judgement.rule(Strategy(strategy))
    elif primary is not None:
        raise typer.BadParameter(f"{primary} alone, expected its safety policy after it")
    elif strategy is not Driving.reference:
        raise typer.BadParameter(f"--strategy {strategy} needs a primary and its safety policy")
    task = DrivingTask(
        tracks=track,
        traffic=traffic,
        record_every=record_every,
        seconds=seconds,
    )
    plan, fps = Plan(task, track, rule, (seed,)), task.fps
    frames = watched(plan, driver, judgement)
    tally = Tally()
    with options.rerun_sink(save, web, live_blueprint(fps)) as sink:
        name, title = f"{track}/{strategy}/{seed}", f"{strategy}, {plan.description}, seed {seed}"
        with new_recording(name, title, make_track(track), sink.connect) as recording:
            tracer = drive_tracer(recording, fps=fps, judgement=judgement, camera=RAW)
            with suppress(KeyboardInterrupt):
                for world, footage in frames if save else in_real_time(frames, fps):
                    if not sink.is_open():
                        break
                    tracer.send(footage)
                    tally.add(world, footage)
            typer.echo(tally)
