"""What an iteration cost: frames driven, queries, frames trained on."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from stages import options


def ledger(
    raw: Annotated[
        Path, typer.Argument(help="Every frame driven: D', or D_0 and D_safe themselves.")
    ],
    aggregate: Annotated[Path, typer.Argument(help="What was trained on: D_i.")],
    metrics: options.Metrics,
) -> None:
    """Count frames driven, queries, frames trained on.

    And what the drives took, and what became of them. Of an iteration, from its datasets.
    """
    from pipeline.data.dataset import Dataset
    from pipeline.data.ledger import count
    from pipeline.evaluation.writing import write_rows
    from pipeline.metric import COLLECTED, SPENT
    from pipeline.output import check_place

    check_place(metrics)
    counted = count(Dataset.open(raw), Dataset.open(aggregate))
    write_rows(metrics, counted, {**SPENT, **COLLECTED})
    typer.echo(f"{metrics}: {in_words(counted)}")


def in_words(counted: Mapping[str, float | None]) -> str:
    """An iteration's ledger on one line; of what became of the drives, what is known."""
    from pipeline.metric import FAILURE

    parts = [
        "{frames_driven:,} frames of {drives:,} drives in {scenarios:,} scenarios",
        "{queries:,} queries, {audits:,} of them audits",
        "{calls:,} calls of the reference for {frames_of_calls:,} frames, {switches:,} switches",
        "{frames_selected:,} frames selected, {frames_trained:,} trained on",
    ]
    told = {name: value for name, value in counted.items() if value is not None}
    kinds = [
        f"{name.removeprefix(FAILURE).replace('_', ' ')} {value:,}"
        for name, value in told.items()
        if name.startswith(FAILURE)
    ]
    if "put_back" in told:
        parts.append("put back {put_back:,} times")
    if "failures" in told:
        parts.append(f"{{failures:,}} failures ({', '.join(kinds)})")
    return "; ".join(parts).format(**told)
