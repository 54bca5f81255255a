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
    from pipeline.inspection.drawn import track_to_draw
    from pipeline.inspection.footage import Footage
    from pipeline.inspection.live import watched
    from pipeline.inspection.pairs import Pair
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_pair
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement, rule_of
    from pipeline.rollout.plans import SEED_STREAMS, Plan
    from pipeline.rollout.strategies import parse_driving

    track, how, computes = track_to_draw(task), parse_driving(strategy), find_device(device)
    sides = [
        (Driver.load(primary, safety, device=computes), Judgement.read(safety, cut))
        for primary, safety in ((primary_a, safety_a), (primary_b, safety_b))
    ]
    fps = task.fps
    with options.rerun_sink(save, web, port, pair_blueprint(fps)) as sink:
        drives, tallies = [], []
        with options.progress("driving", len(sides)) as advance_to:
            for number, (driver, judgement) in enumerate(sides):
                frames = []
                plan = Plan(task, track.name, rule_of(how, judgement), (seed, SEED_STREAMS["film"]))
                for footage, tally in watched(plan, driver, judgement):
                    frames.append(footage)
                    advance_to(number + tally.done)
                drives.append((Footage.joined(frames), judgement))
                tallies.append(tally)
        for name, tally in zip(
            (f"a, {primary_a.name}", f"b, {primary_b.name}"), tallies, strict=True
        ):
            typer.echo(f"{name}: {tally}")
        pair = Pair(
            f"{strategy}, {plan.description}, seed {seed}: a is {primary_a.name}, b is {primary_b.name}",
            f"{track.name}/{strategy}/{seed}/{primary_a.name}/{primary_b.name}",
            track,
            *drives,
        )
        log_pair(pair, sink.connect, fps=fps)
