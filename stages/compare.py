"""See two iterations side by side: the same tasks, done by each."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def compare(
    a: Annotated[Path, typer.Argument(help="A dataset, of an iteration's rollout say ...")],
    b: Annotated[Path, typer.Argument(help="... and another one, with some of the same tasks.")],
    drive: Annotated[
        int, typer.Option(min=0, help="Which drive of each task; 0 is the first.")
    ] = 0,
    save: options.Save = None,
    web: options.Web = False,
    port: options.Port = 0,
) -> None:
    """Show two datasets side by side in Rerun.

    One recording for each task that both have; of the car's, for each track.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.inspection.footage import is_of_the_car, track_of
    from pipeline.inspection.pairs import pairs
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_pair
    from pipeline.inspection.rerun_plain import log_plain_pair, plain_blueprint

    first, second = Dataset.open(a), Dataset.open(b)
    fps = first.fps
    if all([is_of_the_car(first), is_of_the_car(second)]):
        found = pairs(first, second, drive, place=lambda task: track_of(task).name)
        log, blueprint = log_pair, pair_blueprint(fps)
    else:
        found = pairs(first, second, drive)
        log, blueprint = log_plain_pair, plain_blueprint(first, second)
    with options.rerun_sink(save, web, port, blueprint) as sink:
        for pair in found:
            log(pair, sink.connect, fps=fps)
