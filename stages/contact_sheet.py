"""The paper's appendix: sample frames sorted by what the safety policy thinks of them."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def contact_sheet(
    dataset: options.Dataset,
    output: Annotated[Path, typer.Argument(help="Where to draw it (PNG). It must not exist.")],
    frames: Annotated[int, typer.Option(min=1, help="How many of each; 10 in the paper.")],
    camera: Annotated[
        str | None, typer.Option(help="Which column of pictures; by default the first.")
    ] = None,
) -> None:
    """Draw the safest and the least safe frames (PNG).

    Of a rollout, with their probability of being safe.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.data.images import read_some_images
    from pipeline.inspection.canvas import png
    from pipeline.inspection.contact_sheet import Shown, extreme_frames
    from pipeline.inspection.contact_sheet import contact_sheet as draw
    from pipeline.output import write_file

    rollout = Dataset.open(dataset)
    probability = rollout.column("safe_probability")
    chosen = extreme_frames(probability, rollout.episode_index, frames)
    rows = sorted({int(row) for part in chosen for row in part})
    seen = camera or next(iter(rollout.cameras), "")
    images = dict(zip(rows, read_some_images(rollout, seen, rows), strict=True))
    episode, starts = rollout.episode_index, [start for start, _ in rollout.bounds]
    safest, least_safe = (
        [
            Shown(images[row], probability[row], episode[row], row - starts[episode[row]])
            for row in part.tolist()
        ]
        for part in chosen
    )
    title = f"{dataset.name}: probability of being safe"
    write_file(output, png(draw(title, safest, least_safe)))
    typer.echo(f"{output}: {frames} safest and {frames} least safe of {len(rollout)} frames")
