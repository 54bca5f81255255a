"""Lines 3 and 9 of Algorithm 1: fit pi_i to D_i."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def train_primary(
    context: typer.Context,
    dataset: options.Dataset,
    output: options.Output,
    channels: Annotated[int, typer.Option(min=1, help="Of Conv1 to Conv4; 64 in the paper.")],
    optimizer: options.Optimizer,
    learning_rate: options.LearningRate,
    weight_decay: options.WeightDecay,
    batch: options.Batch,
    passes: options.Passes,
    validation: options.Validation,
    patience: options.Patience,
    jitter: Annotated[
        float, typer.Option(help="How far brightness, contrast and colours are moved, [0, 1).")
    ],
    mirror: Annotated[
        bool, typer.Option(help="Show half of the images as in a mirror, labels and all.")
    ],
    steering_weight: Annotated[
        float, typer.Option(min=0, help="Weight of the steering in the loss.")
    ],
    brake_weight: Annotated[float, typer.Option(min=0, help="Weight of the brake in the loss.")],
    brake_on: Annotated[
        float, typer.Option(min=0, help="Class weight of the brake being on, the rare label.")
    ],
    brake_cut: Annotated[
        float, typer.Option(min=0, max=1, help="Brake where its probability is above this.")
    ],
    seed: options.Seed,
    threads: options.Threads,
    initial: Annotated[
        Path | None, typer.Option(help="A primary policy to start from, else from scratch.")
    ] = None,
) -> None:
    """Train a primary to imitate the reference (lines 3, 9)."""
    from pipeline.data.dataset import Dataset
    from pipeline.data.images import read_images
    from pipeline.data.labels import check_labels
    from pipeline.data.lineage import Recipe
    from pipeline.driving.features import CAMERA, IMITATED
    from pipeline.driving.network import LossWeights
    from pipeline.driving.policy import PrimaryConfig, PrimaryPolicy
    from pipeline.driving.traffic import SENSOR_RANGE
    from pipeline.learning.settings import PrimarySettings
    from pipeline.learning.training import train_primary as train
    from pipeline.output import new_directory
    from pipeline.policies.loading import load_primary, policy_lineage, weights_sha256

    loss = LossWeights(steering=steering_weight, brake=brake_weight, brake_on=brake_on)
    settings = PrimarySettings(
        optimizer=optimizer.value,
        learning_rate=learning_rate,
        weight_decay=weight_decay,
        passes=passes,
        batch=batch,
        validation=validation,
        patience=patience,
        seed=seed,
        threads=threads,
        channels=channels,
        sensor_range=SENSOR_RANGE,
        brake_cut=brake_cut,
        loss=loss,
        jitter=jitter,
        mirror=mirror,
    )
    config = PrimaryConfig(
        channels=channels, sensor_range=SENSOR_RANGE, brake_cut=brake_cut, loss=loss
    )
    with new_directory(output) as folder:
        learned = Dataset.open(dataset)
        learned.require(IMITATED)
        check_labels(learned)
        columns = learned.columns(["action", "affordances"])
        start = load_primary(initial).state_dict() if initial else None
        with options.progress("training", passes) as advance_to:
            network, measured = train(
                read_images(learned, CAMERA),
                columns["action"],
                columns["affordances"],
                learned.episode_index,
                settings,
                initial=start,
                on_epoch=lambda epoch, epochs, metrics: advance_to(metrics["passes"]),
            )
        PrimaryPolicy(config, network).save_pretrained(folder)
        parents = [learned.lineage, *([policy_lineage(initial)] if initial else [])]
        recipe = Recipe("primary", options.arguments(context), parents)
        recipe.lineage(weights_sha256(folder)).write(folder)
    typer.echo(f"{output}: trained on {len(learned)} frames, {options.figures(measured)}")
