"""Lines 3 and 9 of Algorithm 1: fit pi_i to D_i."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.learning.settings import Optimisation
from pipeline.registry import LESSONS
from stages import options


def train_primary(
    context: typer.Context,
    dataset: options.Dataset,
    output: options.Output,
    policy: options.Lesson,
    settings: Optimisation,
    initial: Annotated[
        Path | None, typer.Option(help="A primary policy to start from, else from scratch.")
    ] = None,
    curve: options.Curve = None,
    device: options.Device = "cpu",
) -> None:
    """Train a primary to imitate the reference (lines 3, 9)."""
    from pipeline.data.dataset import Dataset
    from pipeline.data.images import read_all
    from pipeline.data.labels import labelled, told
    from pipeline.data.lineage import Recipe
    from pipeline.learning.training import train_primary as train
    from pipeline.output import check_place, new_directory
    from pipeline.policies.computing import find_device
    from pipeline.policies.loading import load_primary, policy_lineage, weights_sha256

    check_place(output, curve)
    computes = find_device(device)
    with new_directory(output) as folder:
        learned = Dataset.open(dataset)
        features = policy.learned(learned.features)
        try:
            learned.require(features)
        except ValueError as error:
            kinds = f"--policy {policy.name}; there are {', '.join(LESSONS)}"
            raise ValueError(f"{error} ({kinds})") from None
        rows, run = labelled(learned)
        for line in told(learned):
            typer.echo(line)
        start = load_primary(initial).state_dict() if initial else None
        with options.epochs(settings.samples, curve) as on_epoch:
            network, measured = train(
                policy,
                features,
                read_all(learned, features, rows),
                run,
                settings,
                initial=start,
                device=computes,
                on_epoch=on_epoch,
            )
        policy.policy(network).save_pretrained(folder)
        parents = [learned.lineage, *([policy_lineage(initial)] if initial else [])]
        recipe = Recipe("primary", options.arguments(context), parents)
        recipe.lineage(weights_sha256(folder)).write(folder)
    typer.echo(f"{output}: trained on {len(run)} frames, {options.figures(measured)}")
