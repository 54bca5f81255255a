"""What was measured of a policy, as the stages write it down."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.evaluation.drives import read_drives
from pipeline.evaluation.metrics_file import MetricsFile, SafetyQuality
from pipeline.evaluation.summary import CONDITIONS, Performance
from pipeline.rollout.strategies import DRIVING


@dataclass(frozen=True)
class Measured:
    """Of one policy; empty where nothing was measured."""

    driving: Mapping[tuple[str, str], Performance]
    """by strategy and condition: of a primary and its safety policy together"""
    tracks: Sequence[str] = ()
    """where they drove"""
    most_laps: float = 0
    """of a drive: then it was halted"""
    held_out: SafetyQuality | None = None
    """of a safety policy, on held-out frames of D_safe"""
    held_out_frames: int = 0


def read_measured(metrics: Path, step: str, primary: str, *, safety: bool) -> Measured:
    """What `evaluate` and, for a safety policy, `train-safety` have measured in a step; empty where
    that was of another policy, of another seed's say, or nobody knows of which.

    Args:
        metrics: the folder with driving_<step>.json, drives_<step>.csv and safety_<step>.json.
        step: of the policy.
        primary: the SHA-256 of the weights of the primary that drives with it.
        safety: whether it is a safety policy.

    Raises:
        ValueError: a file does not hold what it should.
    """
    drives = metrics / f"drives_{step}.csv"
    if not drives.is_file() or set(read_drives(drives).primary) != {primary}:
        return Measured({})
    measured = _read_driving(driving_file(metrics, step))
    path = metrics / f"safety_{step}.json"
    if not (safety and path.exists()):
        return measured
    file = MetricsFile(path)
    return replace(
        measured,
        held_out=file.record(SafetyQuality, "held_out"),
        held_out_frames=int(file.number("held_out", "frames")),
    )


def driving_file(metrics: Path, step: str) -> Path:
    """Where `evaluate` writes what it has measured in a step."""
    return metrics / f"driving_{step}.json"


def _read_driving(path: Path) -> Measured:
    """Strategies and conditions in their order, those that there are."""
    if not path.exists():
        return Measured({})
    file = MetricsFile(path)
    driving = {
        (str(strategy), condition): file.numbers(strategy, condition)
        for strategy in DRIVING
        for condition in CONDITIONS
        if file.has(strategy, condition)
    }
    if not driving:
        raise ValueError(f"{path}: no strategy's drives, expected some of {', '.join(DRIVING)}")
    tracks = [track.strip() for track in file.text("task", "tracks").split(",")]
    return Measured(driving, tracks, file.number("task", "laps"))
