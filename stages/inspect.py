"""Look into a dataset: what the car saw, what each policy wanted, who drove, and why."""

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
            help="Only takeovers, two seconds before to one second after each; the most unsafe is 0001.",
        ),
    ] = False,
    save: options.Save = None,
    web: options.Web = False,
    cut: options.Cut = 0.5,
    tau: options.Tau = 0.0025,
) -> None:
    """Show a dataset in Rerun, a recording an episode."""
    from pipeline.data.reading import check_dataset
    from pipeline.data.schema import CONTROL_HZ
    from pipeline.inspection.excerpts import around_takeovers, whole_episodes
    from pipeline.inspection.rerun_blueprints import drive_blueprint
    from pipeline.inspection.rerun_log import log_excerpt

    fps = CONTROL_HZ // check_dataset(dataset)
    excerpts = around_takeovers(dataset, episode) if unsafe else whole_episodes(dataset, episode)
    with options.rerun_sink(save, web, drive_blueprint(fps)) as sink:
        for excerpt in excerpts:
            log_excerpt(excerpt, sink.connect, fps=fps, cut=cut, tau=tau)
