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
    from pipeline.driving.tracks import make_track
    from pipeline.inspection.drawn import plan_to_draw, watched
    from pipeline.inspection.footage import Footage
    from pipeline.inspection.pairs import Pair
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_pair
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.strategies import parse_driving

    how, computes = parse_driving(strategy), find_device(device)
    policies = ((primary_a, safety_a), (primary_b, safety_b))
    judged = [Judgement.read(safety, cut) for _, safety in policies]
    plans = [plan_to_draw(task, how, judgement, seed) for judgement in judged]
    drivers = [Driver.load(*pair, device=computes) for pair in policies]
    fps, plan = task.fps, plans[0]
    with options.rerun_sink(save, web, port, pair_blueprint(fps)) as sink:
        drives, told = [], []
        with options.progress("driving", len(plans)) as advance_to:
            for number, side in enumerate(zip(plans, drivers, judged, strict=True)):
                frames = []
                for footage, tally in watched(*side):
                    frames.append(footage)
                    advance_to(number + tally.done)
                drives.append((Footage.joined(frames), judged[number]))
                told.append(f"{'ab'[number]}, {policies[number][0].name}: {tally}")
        typer.echo("\n".join(told))
        pair = Pair(
            f"{strategy}, {plan.description}, seed {seed}: a is {primary_a.name}, b is {primary_b.name}",
            f"{plan.scenario}/{strategy}/{seed}/{primary_a.name}/{primary_b.name}",
            make_track(plan.scenario),
            *drives,
        )
        log_pair(pair, sink.connect, fps=fps)
