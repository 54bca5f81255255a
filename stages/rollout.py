"""Line 6 of Algorithm 1: collect D' with the safe strategy."""

from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options
from stages.recording import keep

if TYPE_CHECKING:
    from pipeline.rollout.recording import Recording


def rollout(
    context: typer.Context,
    primary: options.Primary,
    safety: options.Safety,
    output: options.Output,
    task: options.Task,
    queries: Annotated[
        int,
        typer.Option(min=1, help="Stop when the reference has been asked so often, audits too ..."),
    ] = 3000,
    frames: Annotated[
        int, typer.Option(min=1, help="... or so many frames have been driven.")
    ] = 40_000,
    iteration: options.Iteration = 1,
    metrics: options.MetricsIfAny = None,
    seed: options.Seed = 0,
    workers: options.Workers = None,
    cut: options.Cut = None,
    resume: options.Resume = None,
    least: options.Least = None,
    audit: Annotated[
        float | None,
        typer.Option(
            min=0,
            max=1,
            help="Ask about this share of the frames that the primary drives, whatever the safety "
            "policy says of them; the primary drives them nevertheless; 0.",
        ),
    ] = None,
    hold: options.Hold = None,
    device: options.Device = "cpu",
) -> None:
    """Drive by the safe strategy, keep all (D', line 6)."""
    import numpy as np

    from pipeline.data.lineage import Recipe
    from pipeline.data.schema import Asked
    from pipeline.evaluation.writing import write_rows
    from pipeline.learning.audits import estimated_recall
    from pipeline.learning.labels import LabelRule
    from pipeline.learning.quality import detection_quality
    from pipeline.metric import QUALITY
    from pipeline.output import check_place
    from pipeline.policies.computing import find_device
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import policy_lineage, read_labels
    from pipeline.rollout.judgement import Judgement, rule_of
    from pipeline.rollout.plans import stream
    from pipeline.rollout.recording import record_all, until_queries
    from pipeline.rollout.rules.audit import Audit
    from pipeline.rollout.strategies import Strategy

    check_place(output, metrics)
    computes = find_device(device)
    judgement = Judgement.read(safety, cut)
    calm = rule_of(Strategy.SAFE, judgement, resume=resume, least=(least or 0) * task.fps)
    drives = record_all(
        task,
        Audit(calm, audit or 0.0),
        Driver.load(primary, safety, hold=hold or 1, device=computes),
        count(),
        seed=(seed, stream("rollout", iteration)),
        iteration=iteration,
        workers=workers,
    )
    labels = read_labels(safety)
    held_against = LabelRule.of(labels)
    met: list[tuple[np.ndarray, ...]] = []

    def judged() -> Iterator["Recording"]:
        for recording in until_queries(drives, queries, frames):
            columns = recording.episode.columns
            deviation = held_against.deviation(
                columns["primary_action"],
                recording.reference_actions,
                columns["source.episode"][:, 0],
                task.fps,
            )
            why = columns["asked_because"][:, 0]
            met.append((columns["safe_probability"][:, 0], deviation, why))
            yield recording

    # the labels too: whoever looks at the rollout later has no safety policy at hand
    arguments = options.arguments(context) | {"cut": judgement.cut, "labels": labels}
    recipe = Recipe("rollout", arguments, [policy_lineage(primary), policy_lineage(safety)])
    summary = keep(judged(), output, recipe, task, what="queries", total=queries)
    tau = labels["tau"]
    probability, deviation, why = (np.concatenate(parts) for parts in zip(*met, strict=True))
    # of what was asked about alone nothing can be said: the safety policy chose it
    unbiased = task.can_look_up or bool((why != Asked.NOT).all())
    measured = deviation if unbiased else np.full_like(deviation, np.nan)
    quality = detection_quality(probability, measured, tau, judgement.cut)
    estimated = {}
    if audit and not labels["horizon"]:  # labels that look ahead need frames that nobody was asked
        known = np.where(why != Asked.NOT, deviation, np.nan)
        called = ~(probability >= judgement.cut)
        estimated = estimated_recall(known, called, why == Asked.AUDIT, audit, tau)
    if metrics:
        write_rows(metrics, {"tau": tau, **quality, **estimated}, QUALITY)
    both = [quality, estimated] if estimated else [quality]
    typer.echo("; ".join([summary, *map(options.figures, both)]))
