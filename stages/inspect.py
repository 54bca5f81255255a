"""Look into a dataset: what the car saw, what each policy wanted, who drove, and why."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def inspect(
    dataset: options.Dataset,
    episode: Annotated[int | None, typer.Option(help="Only this episode; 0 is the first.")] = None,
    unsafe: Annotated[
        bool,
        typer.Option(
            "--unsafe",
            help="Only takeovers: two seconds before to one second after each, most unsafe first.",
        ),
    ] = False,
    save: Annotated[
        Path | None, typer.Option(help="Write a Rerun file (.rrd) instead. It must not exist.")
    ] = None,
    web: Annotated[
        bool, typer.Option("--web", help="Serve it to a browser on this machine instead.")
    ] = False,
    cut: options.Cut = 0.5,
    tau: Annotated[
        float, typer.Option(min=0, help="A frame is unsafe above this deviation.")
    ] = 0.0025,
) -> None:
    """Show a dataset in Rerun, one recording for each episode."""
    from pipeline.data.reading import check_dataset
    from pipeline.data.schema import CONTROL_HZ
    from pipeline.inspection.excerpts import around_takeovers, whole_episodes
    from pipeline.inspection.rerun_blueprints import drive_blueprint
    from pipeline.inspection.rerun_log import log_excerpt
    from pipeline.inspection.rerun_sinks import into_file, into_viewer

    if save is not None and web:
        raise typer.BadParameter("--save and --web exclude each other")
    fps = CONTROL_HZ // check_dataset(dataset)
    excerpts = around_takeovers(dataset, episode) if unsafe else whole_episodes(dataset, episode)
    if save is not None:
        with into_file(save, drive_blueprint(fps)) as connect:
            for excerpt in excerpts:
                log_excerpt(excerpt, connect, fps=fps, cut=cut, tau=tau)
        typer.echo(f"{save}: open it with `rerun {save}`")
        return
    with (
        suppress(KeyboardInterrupt),
        into_viewer(drive_blueprint(fps), web=web) as (connect, address),
    ):
        if web:
            typer.echo(f"{address} (Ctrl-C to end)")
        for excerpt in excerpts:
            log_excerpt(excerpt, connect, fps=fps, cut=cut, tau=tau)
