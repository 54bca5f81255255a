"""See two policies side by side: the same road, start and traffic, driven by each."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def compare_policies(
    primary_a: Annotated[Path, typer.Argument(help="A primary policy ...")],
    safety_a: Annotated[Path, typer.Argument(help="... and its safety policy.")],
    primary_b: Annotated[Path, typer.Argument(help="Another primary policy ...")],
    safety_b: Annotated[Path, typer.Argument(help="... and its safety policy.")],
    task: options.Task,
    strategy: options.Strategy,
    seed: options.Seed,
    cut: options.Cut = None,
    device: options.Device = "cpu",
    save: options.Save = None,
    web: options.Web = False,
    port: options.Port = 0,
) -> None:
    """Let two policies drive the same road, in Rerun.

    From the same start, among the same cars.
    """
    from pipeline.inspection.drawn import plan_to_draw, watched
    from pipeline.inspection.footage import Footage, track_of
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_two_drives
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.strategies import parse_driving

    how, computes = parse_driving(strategy), find_device(device)
    sides = []
    for side, primary, safety in (("a", primary_a, safety_a), ("b", primary_b, safety_b)):
        judgement = Judgement.read(safety, cut)
        plan = plan_to_draw(task, how, judgement, seed)
        driver = Driver.load(primary, safety, device=computes)
        sides.append((f"{side}, {primary.name}", plan, driver, judgement))
    fps = task.fps
    with options.rerun_sink(save, web, port, pair_blueprint(fps)) as sink:
        drives, told = [], []
        with options.progress("driving", len(sides)) as advance_to:
            for before, (name, plan, driver, judgement) in enumerate(sides):
                frames = []
                for footage, tally in watched(plan, driver, judgement):
                    frames.append(footage)
                    advance_to(before + tally.done)
                drives.append((Footage.joined(frames), judgement))
                told.append(f"{name}: {tally}")
        typer.echo("\n".join(told))
        log_two_drives(
            f"{plan.scenario}/{strategy}/{seed}/{primary_a.name}/{primary_b.name}",
            f"{strategy}, {plan.description}, seed {seed}: a is {primary_a.name}, b is {primary_b.name}",
            track_of(plan.description),
            (drives[0], drives[1]),
            sink.connect,
            fps=fps,
        )
