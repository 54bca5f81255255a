"""Sec. 4.4: drive each scenario of a task by each strategy, in all conditions or some."""

from pathlib import Path
from typing import Annotated

import typer

from stages import options


def evaluate(
    primary: options.Primary,
    task: options.Task,
    drives: Annotated[Path, typer.Option(help="Where to write each drive's outcome (CSV).")],
    metrics: options.Metrics,
    safety: options.SafetyIfAny = None,
    strategies: Annotated[
        str | None,
        typer.Option(
            help="Driving strategies, separated by commas; by default naive, and with a safety policy safe."
        ),
    ] = None,
    conditions: Annotated[
        str | None,
        typer.Option(help="Which of the task's conditions, separated by commas; by default all."),
    ] = None,
    starts: Annotated[
        int, typer.Option(min=1, help="Drives of each scenario, from different places.")
    ] = 1,
    seed: options.Seed = 0,
    workers: options.Workers = None,
    cut: options.Cut = None,
    resume: options.Resume = None,
    least: options.Least = None,
    hold: options.Hold = None,
    device: options.Device = "cpu",
) -> None:
    """Evaluate policies by driving strategies (Section 4.4)."""
    from dataclasses import asdict

    from pipeline.evaluation.drives import table, write_drives
    from pipeline.evaluation.driving import evaluate as evaluate_drive
    from pipeline.evaluation.driving import trials
    from pipeline.evaluation.summary import headline
    from pipeline.evaluation.writing import write_metrics
    from pipeline.output import check_place
    from pipeline.policies.computing import find_device, processor
    from pipeline.policies.inference import Driver
    from pipeline.policies.loading import begun_with, weights_sha256
    from pipeline.rollout.judgement import Judgement, rule_of
    from pipeline.rollout.strategies import parse_driving
    from pipeline.rollout.workers import in_order
    from pipeline.settings import listed

    check_place(drives, metrics)
    driver = Driver.load(primary, safety, hold=hold or 1, device=find_device(device))
    driver.check_task(task.name, task.features)
    judgement = Judgement.read(safety, cut) if safety else None
    told = strategies or ("naive,safe" if safety else "naive")
    rules = [
        rule_of(parse_driving(name), judgement, resume=resume, least=(least or 0) * task.fps)
        for name in listed(told)
    ]
    known = task.conditions
    among = listed(conditions) if conditions is not None else list(known)
    for name in among:
        if name not in known:
            raise ValueError(f"--conditions {name!r}: expected some of {', '.join(known)}")
    told_of_primary = {
        "primary": weights_sha256(primary),
        "begun_with": begun_with(primary),
        "processor": processor(),
    }
    planned = list(trials(task, among, rules, starts, seed=seed))
    rows = []
    with options.progress("driving", len(planned)) as advance_to:
        for row in in_order(evaluate_drive, ((trial, driver) for trial in planned), workers):
            rows.append(row)
            advance_to(len(rows))
    driven = table(rows).assign(**told_of_primary)
    write_drives(drives, driven)
    by_hand = {"cut": cut, "resume": resume, "least": least, "hold": hold}
    chosen = {name: value for name, value in by_hand.items() if value is not None}
    settings = [
        {"condition": name, "name": task.name, **asdict(known[name]), **chosen} for name in among
    ]
    write_metrics(metrics, {**headline(driven, task.metrics), "rows": settings})
    typer.echo(
        f"{metrics}: {len(driven)} drives, {driven.frames.sum()} frames, "
        f"{driven.takeover_frames.sum()} of them by the reference; {options.endings(driven.ended)}"
    )
