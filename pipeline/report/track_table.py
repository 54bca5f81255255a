"""What each run has come to on each test track."""

from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.summary import CONDITIONS, Performance, measure
from pipeline.evaluation.wording import NOTHING, amount, laps, share, table
from pipeline.report.tables import NAIVE, SAFE
from pipeline.rollout.strategies import Strategy


def by_track(experiment: Experiment) -> str:
    """A row for each run and track, after the run's last iteration, over all its seeds."""
    rows = []
    for run in experiment.runs:
        steps = experiment.of(run, experiment.iterations(run)[-1])
        for track in sorted({drive.track for step in steps for drive in step.drives}):
            naive, safe = (_by_condition(steps, strategy, track) for strategy in (NAIVE, SAFE))
            rows.append(
                [
                    RUNS[run],
                    track,
                    " / ".join(laps(one.laps) if one else NOTHING for one in naive),
                    " / ".join(laps(one.laps) if one else NOTHING for one in safe),
                    " / ".join(amount(one.damage_per_lap) if one else NOTHING for one in naive),
                    " / ".join(share(one.takeover) if one else NOTHING for one in safe),
                ]
            )
    header = ["Laps, naive", "Laps, safe", "Damage per lap, naive", "Takeover, safe"]
    return table(["Run", "Track", *header], rows, words=2)


def _by_condition(steps: list[Step], strategy: Strategy, track: str) -> list[Performance | None]:
    """Without and with traffic; None where nobody drove."""
    groups = [
        [d for step in steps for d in step.drives_of(strategy, where) if d.track == track]
        for where in CONDITIONS
    ]
    return [measure(drives) if drives else None for drives in groups]
