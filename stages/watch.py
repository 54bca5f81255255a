"""Watch a drive while it is driven: any policies, strategy and track."""

from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from stages import options


class Driving(StrEnum):
    """Who drives."""

    naive = "naive"
    safe = "safe"
    optimal = "optimal"
    reference = "reference"


def watch(
    task: options.Task,
    primary: Annotated[
        Path | None, typer.Argument(help="A primary policy, as train-primary writes it.")
    ] = None,
    safety: options.SafetyIfAny = None,
    strategy: Annotated[
        Driving | None,
        typer.Option(
            help="Who drives; by default safe, without a safety policy naive, without any reference."
        ),
    ] = None,
    seed: options.Seed = 0,
    cut: options.Cut = None,
    device: options.Device = "cpu",
    save: options.Save = None,
    web: options.Web = False,
    port: options.Port = 0,
) -> None:
    """Drive, and show it in Rerun meanwhile. Ctrl-C ends the drive."""
    from pipeline.inspection.drawn import Tally, track_to_draw
    from pipeline.inspection.footage import Footage
    from pipeline.inspection.live import in_real_time, watched
    from pipeline.inspection.rerun_blueprints import drive_blueprint, live_blueprint
    from pipeline.inspection.rerun_log import drive_tracer, new_recording
    from pipeline.inspection.rerun_traces import COMPRESSED, RAW
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement, rule_of
    from pipeline.rollout.plans import SEED_STREAMS, Plan
    from pipeline.rollout.strategies import Strategy

    track, computes = track_to_draw(task), find_device(device)
    if strategy is None:
        strategy = Driving.safe if safety else Driving.naive if primary else Driving.reference
    if primary is None and strategy is not Driving.reference:
        raise ValueError(f"strategy is {strategy}, which needs a primary")
    driver = Driver.load(primary, safety, device=computes) if primary else None
    judgement = Judgement.read(safety, cut) if safety else None
    plan = Plan(
        task, track.name, rule_of(Strategy(strategy), judgement), (seed, SEED_STREAMS["film"])
    )
    fps, tally = task.fps, Tally()
    frames = watched(plan, driver, judgement)
    saved: list[Footage] = []  # at once, so that a file has all views
    blueprint = drive_blueprint(fps) if save else live_blueprint(fps)
    with options.rerun_sink(save, web, port, blueprint) as sink:
        name = f"{track.name}/{strategy}/{seed}"
        title = f"{strategy}, {plan.description}, seed {seed}"
        with new_recording(name, title, track, sink.connect) as recording:
            tracer = drive_tracer(
                recording, fps=fps, judgement=judgement, camera=COMPRESSED if save else RAW
            )
            show = saved.append if save else tracer.send
            with suppress(KeyboardInterrupt), options.progress(track.name, 1) as advance_to:
                for footage, tally in frames if save else in_real_time(frames, fps):
                    if not sink.is_open():
                        break
                    show(footage)
                    advance_to(tally.done)
            if saved:
                tracer.send(Footage.joined(saved))
            typer.echo(tally)
