"""Lines 4 and 10 of Algorithm 1: fit pi_safe,i to where pi_i deviates, on D_safe and D_i."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


class HorizonMode(StrEnum):
    """Which deviation of the horizon counts."""

    last = "last"
    max = "max"


@app.command()
def train_safety(
    context: typer.Context,
    primary: options.Primary,
    d_safe: Annotated[Path, typer.Argument(help="D_safe: no primary was trained on it.")],
    dataset: Annotated[Path, typer.Argument(help="D_i: this primary was trained on it.")],
    output: options.Output,
    tau: Annotated[float, typer.Option(min=0, help="Threshold on the deviation: safe up to here.")],
    measure: options.Measure,
    horizon: Annotated[
        float, typer.Option(min=0, help="How far ahead to foresee a deviation [s].")
    ],
    horizon_mode: Annotated[
        HorizonMode,
        typer.Option(help="The deviation at the end of the horizon, or the largest within."),
    ],
    cut: Annotated[
        float,
        typer.Option(min=0, max=1, help="Unsafe is what has a lower probability of being safe."),
    ],
    balance: Annotated[
        float,
        typer.Option(min=0, max=1, help="Class weights: 0 counts each frame alike, 1 each class."),
    ],
    held_out: Annotated[
        float, typer.Option(min=0, max=1, help="Share of D_safe's episodes kept to measure with.")
    ],
    hidden: Annotated[int, typer.Option(min=1, help="Width of each of the two hidden layers.")],
    optimizer: options.Optimizer,
    learning_rate: options.LearningRate,
    weight_decay: options.WeightDecay,
    batch: options.Batch,
    samples: options.Samples,
    validation: options.Validation,
    patience: options.Patience,
    metrics: options.Metrics,
    seed: options.Seed,
    threads: options.Threads,
    features_of: Annotated[
        str,
        typer.Option(help="Of a primary of LeRobot's: the module whose input it reads."),
    ] = "",
    device: options.Device = "cpu",
) -> None:
    """Train a primary's safety policy (lines 4 and 10).

    To tell, without asking the reference, where the primary deviates from it.
    """
    from functools import partial

    import numpy as np

    from pipeline.data.dataset import Dataset
    from pipeline.data.identity import refuse_shared
    from pipeline.data.lineage import Recipe
    from pipeline.evaluation.writing import write_metrics
    from pipeline.learning.labels import LabelRule, safe_labels
    from pipeline.learning.quality import detection_quality
    from pipeline.learning.safety import held_out_episodes, judge
    from pipeline.learning.settings import SafetySettings
    from pipeline.learning.training import safe_probabilities
    from pipeline.learning.training import train_safety as train
    from pipeline.output import check_place, new_directory
    from pipeline.policies.computing import find_device
    from pipeline.policies.loading import load_primary, policy_lineage, weights_sha256
    from pipeline.policies.measures import half_range
    from pipeline.policies.safety import SafetyConfig, SafetyPolicy

    check_place(metrics)
    computes = find_device(device)
    settings = SafetySettings(
        optimizer=optimizer.value,
        learning_rate=learning_rate,
        weight_decay=weight_decay,
        samples=samples,
        batch=batch,
        validation=validation,
        patience=patience,
        seed=seed,
        threads=threads,
        hidden=hidden,
        balance=balance,
    )
    network = load_primary(primary, features_of, computes)
    safe_data, own_data = Dataset.open(d_safe), Dataset.open(dataset)
    half_ranges = half_range(safe_data.features.get("action", network.action))
    config = SafetyConfig(
        primary_sha256=weights_sha256(primary),
        features_of=features_of,
        features=network.feature_size,
        hidden=hidden,
        tau=tau,
        cut=cut,
        measure=measure,
        half_range=half_ranges,
        horizon=horizon,
        horizon_mode=horizon_mode.value,
        balance=balance,
    )
    rule = LabelRule(measure, horizon, horizon_mode.value, half_ranges)
    with new_directory(output) as folder:
        refuse_shared(own_data, safe_data)
        judged = partial(judge, network, rule=rule)
        unseen = judged(safe_data)
        kept = held_out_episodes(unseen, held_out, np.random.default_rng(seed))
        shown = unseen.only(~kept) + judged(own_data)
        safe = safe_labels(shown.deviation, tau)
        if len(np.unique(safe)) == 1:
            kind = "safe" if safe[0] else "unsafe"
            typer.echo(f"all frames to learn from are {kind}: it will call any {kind}", err=True)
        with options.progress("training", samples) as advance_to:
            safety, _ = train(
                shown.features,
                safe,
                shown.episode_index,
                settings,
                device=computes,
                on_epoch=lambda epoch, epochs, now: advance_to(now["samples"]),
            )
        SafetyPolicy(config, safety).save_pretrained(folder)
        parents = [policy_lineage(primary), safe_data.lineage, own_data.lineage]
        recipe = Recipe("safety", options.arguments(context), parents)
        recipe.lineage(weights_sha256(folder)).write(folder)
        measured = unseen.only(kept)
        quality = detection_quality(
            safe_probabilities(safety, measured.features), measured.deviation, tau, cut
        )
    write_metrics(metrics, {"tau": tau, "held_out": quality})
    typer.echo(
        f"{output}: trained on {len(shown.deviation)} frames; held out: {options.figures(quality)}"
    )
