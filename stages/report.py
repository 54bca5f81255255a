"""Report what the training strategies have come to (Sec. 5).

Reads the metrics of every seed and run, and the pictures of each seed; writes the report as
markdown, and its figures.
"""

from pathlib import Path
from typing import Annotated

import typer

ERRORS = "How the supervised primary's errors lie around tau (the paper's Fig. 2)"
FRAMES = "What the first safety policy found safest and least safe (the paper's appendix)"


def report(
    metrics: Annotated[Path, typer.Option(help="Folder of seed_<n>/drives_<run>_<i>.csv, ...")],
    errors: Annotated[Path, typer.Option(help="Folder of seed_<n>.png, drawn by `errors`.")],
    frames: Annotated[Path, typer.Option(help="Folder of seed_<n>.png, drawn by `contact-sheet`.")],
    output: Annotated[Path, typer.Option(help="The report to write, markdown.")],
    figures: Annotated[Path, typer.Option(help="Folder for the report's figures, PNG.")],
    curves: Annotated[
        Path | None, typer.Option(help="Folder of seed_<n>/reliability_<run>_<i>.csv, ...")
    ] = None,
) -> None:
    """Write the report: verdicts, figures, every number."""
    from pipeline.driving.tracks import TEST, TRAINING
    from pipeline.evaluation.curves import yardstick
    from pipeline.evaluation.experiment import STEP
    from pipeline.inspection.canvas import png
    from pipeline.inspection.tracks import track_sheet
    from pipeline.output import check_place, seen_from, write_file
    from pipeline.report.figures import TITLES, over_the_iterations, result
    from pipeline.report.label_curves import label_curves
    from pipeline.report.material import read_material
    from pipeline.report.rendering import Pictures, render_report

    sheets = {"training": ("Training tracks", TRAINING), "test": ("Test tracks", TEST)}
    paths = {name: figures / f"{name}.png" for name in ("labels", "result", *TITLES, *sheets)}
    check_place(output, *paths.values())
    for folder in (errors, frames):
        if not folder.is_dir():
            raise FileNotFoundError(f"{folder}: no such folder, expected seed_<n>.png in it")

    material = read_material(metrics, curves)
    drawn = over_the_iterations(material.experiment)
    head = result(material.experiment)
    if head:
        drawn["result"] = head
    best = yardstick(material.curves)
    if best:
        drawn["labels"] = label_curves(material.curves, best)
    for name, (title, tracks) in sheets.items():
        drawn[name] = track_sheet(list(tracks), title)
    pngs = {name: png(figure) for name, figure in drawn.items()}
    places = {name: seen_from(output.parent, paths[name]) for name in pngs}
    text = render_report(
        material,
        Pictures(
            result=places.get("result"),
            labels=places.get("labels"),
            figures={title: places[name] for name, title in TITLES.items() if name in places},
            by_seed={
                title: {
                    seed: seen_from(output.parent, path)
                    for seed in material.experiment.seeds
                    if (path := folder / f"seed_{seed}.png").is_file()
                }
                for title, folder in ((ERRORS, errors), (FRAMES, frames))
            },
            tracks={title: places[name] for name, (title, _) in sheets.items()},
        ),
    )

    for name, picture in pngs.items():
        write_file(paths[name], picture)
    write_file(output, text.encode())
    typer.echo(
        f"{output}: {len(material.experiment.drives.groupby(STEP[:3]))} steps, {len(pngs)} figures in {figures}"
    )
