"""See two iterations side by side: the same tracks, driven by each."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def compare(
    a: Annotated[Path, typer.Argument(help="A dataset, of an iteration's rollout say ...")],
    b: Annotated[Path, typer.Argument(help="... and another one, with some of the same tracks.")],
    drive: Annotated[
        int, typer.Option(min=0, help="Which drive on each track; 0 is the first.")
    ] = 0,
    save: options.Save = None,
    web: options.Web = False,
    port: options.Port = 0,
) -> None:
    """Show two datasets side by side in Rerun.

    One recording for each track that both have.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.inspection.pairs import pairs
    from pipeline.inspection.rerun_blueprints import pair_blueprint
    from pipeline.inspection.rerun_log import log_pair

    first = Dataset.open(a)
    found, fps = pairs(first, Dataset.open(b), drive), first.fps
    with options.rerun_sink(save, web, port, pair_blueprint(fps)) as sink:
        for pair in found:
            log_pair(pair, sink.connect, fps=fps)
