"""Line 6 of Algorithm 1: collect D' with the safe strategy."""

from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING, Annotated

import typer

from stages import options

if TYPE_CHECKING:
    from pipeline.data.schema import Episode

app = typer.Typer()


@app.command()
def rollout(
    context: typer.Context,
    primary: options.Primary,
    safety: options.Safety,
    output: options.Output,
    tracks: options.Tracks,
    traffic: options.Traffic,
    queries: Annotated[
        int, typer.Option(min=1, help="Stop when the reference has been asked so often ...")
    ],
    frames: Annotated[int, typer.Option(min=1, help="... or so many frames have been driven.")],
    seconds: options.Seconds,
    offset_spread: options.OffsetSpread,
    angle_spread: options.AngleSpread,
    record_every: options.RecordEvery,
    iteration: Annotated[
        int, typer.Option(min=1, help="The iteration of Algorithm 1 that this is for.")
    ],
    metrics: options.Metrics,
    seed: options.Seed,
    workers: options.Workers,
    cut: options.Cut = None,
) -> None:
    """Drive by the safe strategy, keep all (D', line 6)."""
    import numpy as np

    from pipeline.data.lineage import Recipe
    from pipeline.data.writing import write_dataset
    from pipeline.driving.features import ROBOT_TYPE, check_record_every
    from pipeline.evaluation.writing import write_metrics
    from pipeline.learning.labels import LabelRule
    from pipeline.learning.quality import detection_quality
    from pipeline.output import check_place
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import policy_lineage, read_labels
    from pipeline.rollout.recording import SEED_STREAMS, Drive, record_all, until_queries
    from pipeline.rollout.rules import driving_rule
    from pipeline.rollout.strategies import Strategy

    check_place(output, metrics)
    names, fps = options.names(tracks), check_record_every(record_every)
    rule = driving_rule(safety, Strategy.SAFE, cut)
    plan = Drive(
        track=names[0],
        traffic=traffic,
        spread=(offset_spread, angle_spread),
        seed=(seed, SEED_STREAMS["rollout"] + iteration),
        rule=rule,
        record_every=record_every,
        seconds=seconds,
    )
    driver = Driver.load(primary, safety)
    drives = record_all(plan, names, count(), driver, iteration=iteration, workers=workers)
    labels = read_labels(safety)
    held_against = LabelRule.of(labels)
    probabilities: list[np.ndarray] = []
    deviations: list[np.ndarray] = []

    def driven() -> Iterator["Episode"]:
        asked = 0
        with options.progress("queries", queries) as advance_to:
            for recording in until_queries(drives, queries, frames):
                yield recording.episode
                columns = recording.episode.columns
                probabilities.append(columns["safe_probability"][:, 0])
                deviations.append(
                    held_against.deviation(
                        columns["primary_action"],
                        recording.reference_actions,
                        columns["source.episode"][:, 0],
                        fps,
                    )
                )
                asked += recording.queries
                advance_to(asked)

    # the labels too: whoever looks at the rollout later has no safety policy at hand
    arguments = options.arguments(context) | {"cut": rule.cut, "labels": labels}
    recipe = Recipe("rollout", arguments, [policy_lineage(primary), policy_lineage(safety)])
    summary = write_dataset(output, driven(), recipe, fps=fps, robot=ROBOT_TYPE)
    tau = labels["tau"]
    quality = detection_quality(
        np.concatenate(probabilities), np.concatenate(deviations), tau, rule.cut
    )
    write_metrics(metrics, {"tau": tau, "rollout": quality})
    typer.echo(f"{summary}; {options.figures(quality)}")
