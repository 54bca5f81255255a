"""Cards of all datasets and policies: what they are, what made them, what they are worth."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def cards(
    datasets: Annotated[Path, typer.Option(help="Folder of datasets.")],
    models: Annotated[Path, typer.Option(help="Folder of policies.")],
    metrics: Annotated[
        Path, typer.Option(help="Folder of drives_<i>.csv, driving_<i>.json, safety_<i>.json.")
    ],
    action_repeat: options.ActionRepeat,
    dataset_cards: Annotated[Path, typer.Option(help="Folder to write. It must not exist.")],
    model_cards: Annotated[Path, typer.Option(help="Folder to write. It must not exist.")],
) -> None:
    """Write a card for each dataset and each policy.

    With front matter for the Hub.
    """
    from pipeline.cards.catalogue import Catalogue
    from pipeline.cards.writing import write_dataset_cards, write_model_cards
    from pipeline.output import check_place, new_directory

    check_place(dataset_cards, model_cards)
    with new_directory(dataset_cards) as for_datasets, new_directory(model_cards) as for_models:
        catalogue = Catalogue(
            datasets, models, dataset_cards=dataset_cards, model_cards=model_cards
        )
        facts = write_dataset_cards(for_datasets, catalogue)
        written = write_model_cards(
            for_models, catalogue, facts, metrics=metrics, action_repeat=action_repeat
        )
    typer.echo(
        f"{len(facts)} cards of datasets in {dataset_cards}, {written} of models in {model_cards}"
    )
