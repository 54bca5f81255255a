"""Sec. 4.4: drive the test tracks by each strategy, without and with traffic."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options

app = typer.Typer()


@app.command()
def evaluate(
    primary: options.Primary,
    safety: options.Safety,
    tracks: options.Tracks,
    traffic: options.Traffic,
    laps: Annotated[float, typer.Option(min=0.01, max=3, help="Most laps of one drive.")],
    starts: Annotated[
        int, typer.Option(min=1, help="Drives on each track, from different places.")
    ],
    seconds: options.Seconds,
    record_every: options.RecordEvery,
    strategies: Annotated[
        str, typer.Option(help="Driving strategies, separated by commas: naive, safe, optimal.")
    ],
    drives: Annotated[Path, typer.Option(help="Where to write each drive's outcome (CSV).")],
    metrics: options.Metrics,
    seed: options.Seed,
    workers: options.Workers,
    cut: options.Cut = None,
) -> None:
    """Evaluate policies by driving strategies (Section 4.4)."""
    from pipeline.driving.task import Driving
    from pipeline.evaluation.driving import evaluate as evaluate_drive
    from pipeline.evaluation.driving import plans
    from pipeline.evaluation.outcomes import write_outcomes
    from pipeline.evaluation.summary import summarise
    from pipeline.evaluation.writing import write_metrics
    from pipeline.output import check_place
    from pipeline.policies.inference import Driver
    from pipeline.rollout.judgement import Judgement
    from pipeline.rollout.strategies import parse_driving
    from pipeline.rollout.workers import in_order

    check_place(drives, metrics)
    driver = Driver.load(primary, safety)
    judgement = Judgement.read(safety, cut)
    task = Driving(
        tracks=tracks,
        traffic=traffic,
        record_every=record_every,
        laps=laps,
        seconds=seconds,
    )
    rules = [judgement.rule(parse_driving(name)) for name in options.names(strategies)]
    planned = list(plans(task, rules, starts, seed=seed))
    outcomes = []
    with options.progress("driving", len(planned)) as advance_to:
        for outcome in in_order(
            evaluate_drive, ((plan, start, driver) for plan, start in planned), workers
        ):
            outcomes.append(outcome)
            advance_to(len(outcomes))
    write_outcomes(drives, outcomes)
    write_metrics(
        metrics, {"tracks": options.names(tracks), "most_laps": laps, **summarise(outcomes)}
    )
    frames = sum(outcome.frames for outcome in outcomes)
    takeovers = sum(outcome.takeover_frames for outcome in outcomes)
    typer.echo(
        f"{metrics}: {len(outcomes)} drives, {frames} frames, {takeovers} of them by the reference"
    )
