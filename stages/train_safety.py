"""Lines 4 and 10 of Algorithm 1: fit pi_safe,i to where pi_i deviates, on D_safe and D_i."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.learning.settings import SafetySettings
from stages import options


def train_safety(
    context: typer.Context,
    primary: options.Primary,
    d_safe: Annotated[
        Path,
        typer.Argument(help="D_safe, or what `split` set aside: no primary was trained on it."),
    ],
    dataset: Annotated[Path, typer.Argument(help="D_i: this primary was trained on it.")],
    output: options.Output,
    settings: SafetySettings,
    audits: Annotated[
        list[Path] | None,
        typer.Option(
            help="What `select --because audit` kept of a rollout, to learn from as well: each frame "
            "counts for as many as it stands for. Can be given several times."
        ),
    ] = None,
    metrics: options.MetricsIfAny = None,
    curve: options.Curve = None,
    features_of: Annotated[
        str,
        typer.Option(
            help="Of a primary of LeRobot's: the module whose input it reads, or name:output."
        ),
    ] = "",
    device: options.Device = "cpu",
) -> None:
    """Train a primary's safety policy (lines 4 and 10).

    To tell, without asking the reference, where the primary deviates from it.
    """
    from dataclasses import replace
    from functools import partial

    import numpy as np

    from pipeline.data.dataset import Dataset
    from pipeline.data.identity import refuse_shared
    from pipeline.data.labels import told
    from pipeline.data.lineage import Recipe
    from pipeline.evaluation.writing import write_rows
    from pipeline.learning.calibration import calibrate
    from pipeline.learning.labels import LabelRule, safe_labels
    from pipeline.learning.quality import detection_quality
    from pipeline.learning.safety import apart, judge
    from pipeline.learning.training import safe_probabilities
    from pipeline.learning.training import train_safety as train
    from pipeline.metric import QUALITY
    from pipeline.output import check_place, new_directory
    from pipeline.policies.computing import find_device
    from pipeline.policies.loading import load_primary, policy_lineage, weights_sha256
    from pipeline.policies.measures import half_range
    from pipeline.policies.safety import SafetyConfig, SafetyPolicy

    check_place(output, metrics, curve)
    computes = find_device(device)
    network = load_primary(primary, features_of, computes)
    settings = replace(settings, measure=settings.measure or network.measure)
    safe_data, own_data = Dataset.open(d_safe), Dataset.open(dataset)
    audited = [Dataset.open(path) for path in audits or ()]
    config = SafetyConfig(
        primary_sha256=weights_sha256(primary),
        features_of=features_of,
        features=network.feature_size,
        half_range=half_range(safe_data.features["action"]),
        **settings.kept,
    )
    with new_directory(output) as folder:
        refuse_shared(own_data, safe_data, *audited)
        trained = policy_lineage(primary)
        if safe_data.lineage.sha256 in trained.own.parents:
            raise ValueError(
                f"{d_safe}: {primary} was trained on it, expected a D_safe (are the two swapped?)"
            )
        for line in [line for each in (safe_data, own_data, *audited) for line in told(each)]:
            typer.echo(line)
        judged = partial(judge, network, rule=LabelRule.of(vars(config)))
        unseen = judged(safe_data)
        rng = np.random.default_rng(settings.seed)
        kept = apart(unseen, settings.held_out, rng, "held_out")
        learned = [
            unseen.only(~kept),
            judged(own_data),
            *(judged(each) for each in audited if len(each)),
        ]
        if settings.calibration:
            # audits are from where it has to judge, D_safe is not
            tells = -1 if len(learned) > 2 else 0
            aside = apart(learned[tells], settings.calibration, rng, "calibration")
            calibrating, learned[tells] = learned[tells].only(aside), learned[tells].only(~aside)
        shown = sum(learned[1:], start=learned[0])
        safe = safe_labels(shown.deviation, settings.tau)
        if len(np.unique(safe)) == 1:
            kind = "safe" if safe[0] else "unsafe"
            told_apart = f"all frames to learn from are {kind}: nothing to tell apart, at this tau"
            typer.echo(told_apart, err=True)
        with options.epochs(settings.samples, curve) as on_epoch:
            safety, _ = train(
                shown.features,
                shown.deviation,
                shown.episode_index,
                settings,
                weight=shown.weight,
                device=computes,
                on_epoch=on_epoch,
            )
        if settings.calibration:
            calibrate(
                safety, calibrating.features, safe_labels(calibrating.deviation, settings.tau)
            )
        SafetyPolicy(config, safety).save_pretrained(folder)
        data = [safe_data, own_data, *audited]
        parents = [trained, *(each.lineage for each in data)]
        arguments = options.arguments(context) | {"measure": settings.measure}
        recipe = Recipe("safety", arguments, parents)
        recipe.lineage(weights_sha256(folder)).write(folder)
        measured = unseen.only(kept)
        probabilities = safe_probabilities(safety, measured.features)
        quality = detection_quality(probabilities, measured.deviation, settings.tau, settings.cut)
    if metrics:
        write_rows(metrics, {"tau": settings.tau, **quality}, QUALITY)
    typer.echo(
        f"{output}: trained on {len(shown.deviation)} frames; held out: {options.figures(quality)}"
    )
