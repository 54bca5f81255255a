"""Look into a dataset: what the car saw, what each policy wanted, who drove, and why."""

from typing import Annotated

import typer

from stages import options


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
    port: options.Port = 0,
) -> None:
    """Show a dataset in Rerun, a recording an episode."""
    from pipeline.data.dataset import Dataset
    from pipeline.inspection.excerpts import (
        around_takeovers,
        megabytes,
        ranked_takeovers,
        whole_episodes,
    )
    from pipeline.inspection.footage import is_of_the_car
    from pipeline.inspection.rerun_blueprints import drive_blueprint
    from pipeline.inspection.rerun_log import log_excerpt
    from pipeline.inspection.rerun_plain import log_plain, plain_blueprint

    opened = Dataset.open(dataset)
    ours = is_of_the_car(opened)
    if unsafe:
        ranked = ranked_takeovers(opened, episode)
        for rank, takeover in enumerate(ranked, 1):
            typer.echo(f"{rank:04d}: {takeover}")
        excerpts = around_takeovers(opened, ranked)
        lengths = [takeover.end - takeover.first for takeover in ranked]
    else:
        excerpts = whole_episodes(opened, episode)
        lengths = opened.lengths.tolist() if episode is None else [opened.lengths[episode]]
    if save and ours:
        size = megabytes(opened, sum(lengths), len(lengths))
        typer.echo(f"{len(lengths)} recordings, {sum(lengths)} frames: about {size:.0f} MB")
    blueprint = drive_blueprint(opened.fps) if ours else plain_blueprint(opened)
    with options.rerun_sink(save, web, port, blueprint) as sink:
        for excerpt in excerpts:
            (log_excerpt if ours else log_plain)(excerpt, sink.connect, fps=opened.fps)
