"""Watch a drive while it is driven: any policies, strategy and track."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import typer

from stages import options


def watch(
    task: options.Task,
    primary: Annotated[
        Path | None, typer.Argument(help="A primary policy, as train-primary writes it.")
    ] = None,
    safety: options.SafetyIfAny = None,
    strategy: Annotated[
        Literal["naive", "safe", "optimal", "reference"] | None,
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
    from pipeline.inspection.drawn import Tally, in_real_time, plan_to_draw, watched
    from pipeline.inspection.footage import Footage, track_of
    from pipeline.inspection.rerun_blueprints import drive_blueprint, live_blueprint
    from pipeline.inspection.rerun_log import drive_tracer, new_recording
    from pipeline.inspection.rerun_traces import COMPRESSED, RAW
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.strategies import Strategy

    computes = find_device(device)
    how = Strategy(strategy or ("safe" if safety else "naive" if primary else "reference"))
    if primary is None and how is not Strategy.REFERENCE:
        raise ValueError(f"strategy is {how}, which needs a primary")
    judgement = Judgement.read(safety, cut) if safety else None
    plan = plan_to_draw(task, how, judgement, seed)
    driver = Driver.load(primary, safety, device=computes) if primary else None
    fps, tally, track = task.fps, Tally(), track_of(plan.description)
    frames = watched(plan, driver, judgement)
    saved: list[Footage] = []  # at once, so that a file has all views
    blueprint = drive_blueprint(fps) if save else live_blueprint(fps)
    with options.rerun_sink(save, web, port, blueprint) as sink:
        name = f"{track.name}/{how}/{seed}"
        title = f"{how}, {plan.description}, seed {seed}"
        with new_recording(name, title, track, sink.connect) as recording:
            send = drive_tracer(
                recording, fps=fps, judgement=judgement, camera=COMPRESSED if save else RAW
            )
            show = saved.append if save else send
            with suppress(KeyboardInterrupt), options.progress(track.name, 1) as advance_to:
                for footage, tally in frames if save else in_real_time(frames, fps):
                    if not sink.is_open():
                        break
                    show(footage)
                    advance_to(tally.done)
            if saved:
                send(Footage.joined(saved))
            typer.echo(tally)
