"""What an iteration cost: frames driven, queries, frames trained on."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def ledger(
    raw: Annotated[
        Path, typer.Argument(help="Every frame driven: D', or D_0 and D_safe themselves.")
    ],
    aggregate: Annotated[Path, typer.Argument(help="What was trained on: D_i.")],
    metrics: options.Metrics,
) -> None:
    """Count frames driven, queries, frames trained on.

    Of an iteration, from the columns of its datasets.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.data.ledger import count
    from pipeline.evaluation.writing import write_rows
    from pipeline.metric import SPENT
    from pipeline.output import check_place

    check_place(metrics)
    counted = count(Dataset.open(raw), Dataset.open(aggregate))
    write_rows(metrics, counted, SPENT)
    typer.echo(f"{metrics}: {options.figures(counted)}")
