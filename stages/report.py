"""Report the results of a run (Sec. 5).

Reads the metrics of every iteration; writes the report as markdown, and its figures.
"""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def report(
    metrics: Annotated[Path, typer.Option(help="Folder of driving_<i>.json, drives_<i>.csv, ...")],
    iterations: Annotated[
        int, typer.Option(min=1, help="Iterations of the loop, after the supervised stage.")
    ],
    errors: Annotated[Path, typer.Option(help="The picture that `errors` drew.")],
    frames: Annotated[Path, typer.Option(help="The picture that `contact-sheet` drew.")],
    output: Annotated[Path, typer.Option(help="The report to write, markdown.")],
    figures: Annotated[Path, typer.Option(help="Folder for the report's figures, PNG.")],
) -> None:
    """Write the report of a run: tables, figures, and what was expected against what came out."""
    from pipeline.evaluation.figures import progress
    from pipeline.evaluation.report import render_report
    from pipeline.evaluation.results import read_results
    from pipeline.evaluation.writing import write_file
    from pipeline.inspection.canvas import png
    from pipeline.inspection.tracks import track_sheet
    from pipeline.output import refuse_existing
    from pipeline.world.tracks import TEST, TRAINING

    sheets = {"Training tracks": ("training.png", TRAINING), "Test tracks": ("test.png", TEST)}
    progress_path = figures / "progress.png"
    for path in (output, progress_path, *(figures / name for name, _ in sheets.values())):
        refuse_existing(path)

    for path in (errors, frames):
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such file, expected a picture")

    results = read_results(metrics, iterations)
    shown = {
        "How the supervised primary's errors lie around tau": errors,
        "What the first safety policy found safest and least safe": frames,
        **{title: figures / name for title, (name, _) in sheets.items()},
    }
    text = render_report(
        results,
        progress=options.seen_from(output, progress_path),
        pictures={title: options.seen_from(output, path) for title, path in shown.items()},
    )
    pictures = {progress_path: png(progress(results))}
    for title, (name, tracks) in sheets.items():
        pictures[figures / name] = png(track_sheet(list(tracks), title))

    for path, picture in pictures.items():
        write_file(path, picture)
    write_file(output, text.encode())
    typer.echo(f"{output}: {iterations} iterations, {len(pictures)} figures in {figures}")
