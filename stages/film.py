"""Show a drive as a film: the track from above, what the car sees, and who drives."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def film(
    primary: options.Primary,
    task: options.Task,
    strategy: options.Strategy,
    show_every: Annotated[int, typer.Option(min=1, help="Frames to a picture of the film.")],
    output: Annotated[Path, typer.Option(help="The film to write (GIF). It must not exist.")],
    seed: options.Seed,
    safety: options.SafetyIfAny = None,
    other: Annotated[
        tuple[Path, Path] | None,
        typer.Option("--beside", help="Another primary and its safety policy, on the right."),
    ] = None,
    cut: options.Cut = None,
    device: options.Device = "cpu",
) -> None:
    """Drive, and write a film of it (GIF).

    Ten pictures a second. With --beside, another pair drives from the same start.
    """
    from pipeline.inspection.drawn import plan_to_draw
    from pipeline.inspection.film import beside, gif, shoot
    from pipeline.output import check_place, write_file
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.strategies import parse_driving

    check_place(output)
    if output.suffix != ".gif":
        raise ValueError(f"{output}: expected a name that ends in .gif")
    computes, how = find_device(device), parse_driving(strategy)
    drives = [
        (
            learner.name,
            plan_to_draw(task, how, Judgement.read(watcher, cut) if watcher else None, seed),
            Driver.load(learner, watcher, device=computes),
        )
        for learner, watcher in ((primary, safety), *([other] if other else []))
    ]
    films, ends = [], []
    with options.progress("driving", len(drives)) as advance_to:
        for before, (name, plan, driver) in enumerate(drives):
            shown = []
            for number, (picture, tally) in enumerate(shoot(plan, driver, name)):
                if number % show_every == 0:
                    shown.append(picture)
                advance_to(before + tally.done)
            films.append(shown)
            ends.append(str(tally))
    pictures = beside(*films)
    write_file(output, gif(pictures, milliseconds=100))
    typer.echo(f"{output}: {len(pictures)} pictures; {' | '.join(ends)}")
