"""The paper's appendix: sample frames sorted by what the safety policy thinks of them."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def contact_sheet(
    dataset: options.Dataset,
    output: Annotated[Path, typer.Argument(help="Where to draw it (PNG). It must not exist.")],
    frames: Annotated[int, typer.Option(min=1, help="How many of each; 10 in the paper.")],
) -> None:
    """Draw the safest and the least safe frames (PNG).

    Of a rollout, with their probability of being safe.
    """
    from pipeline.data.reading import read_columns, read_images
    from pipeline.evaluation.writing import write_file
    from pipeline.inspection.canvas import png
    from pipeline.inspection.contact_sheet import contact_sheet as draw
    from pipeline.inspection.contact_sheet import extreme_frames
    from pipeline.output import refuse_existing

    refuse_existing(output)
    columns = read_columns(dataset, ["safe_probability"])
    probability = columns["safe_probability"][:, 0]
    chosen = extreme_frames(probability, columns["episode_index"], frames)
    images = read_images(dataset)
    safest, least_safe = (
        [(images[row], float(probability[row])) for row in rows] for rows in chosen
    )
    title = f"{dataset.name}: probability of being safe"
    write_file(output, png(draw(title, safest, least_safe)))
    typer.echo(f"{output}: {frames} safest and {frames} least safe of {len(images)} frames")
