"""What was measured of a policy, as the stages write it down."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.evaluation.metrics_file import MetricsFile, SafetyQuality
from pipeline.evaluation.summary import CONDITIONS, Performance
from pipeline.policies.strategies import DRIVING


@dataclass(frozen=True)
class Measured:
    """Of one policy; empty where nothing was measured."""

    driving: Mapping[tuple[str, str], Performance]
    """by strategy and condition: of a primary and its safety policy together"""
    held_out: SafetyQuality | None = None
    """of a safety policy, on held-out frames of D_safe"""
    held_out_frames: int = 0


def read_measured(metrics: Path, step: str, *, safety: bool) -> Measured:
    """What `evaluate` and, for a safety policy, `train-safety` have measured in a step.

    Args:
        metrics: the folder with driving_<step>.json and safety_<step>.json.
        step: of the policy.
        safety: whether it is a safety policy.

    Raises:
        ValueError: a file does not hold what it should.
    """
    driving = _driving(driving_file(metrics, step))
    path = metrics / f"safety_{step}.json"
    if not (safety and path.exists()):
        return Measured(driving)
    file = MetricsFile(path)
    quality = file.record(SafetyQuality, "held_out")
    return Measured(driving, quality, int(file.number("held_out", "frames")))


def driving_file(metrics: Path, step: str) -> Path:
    """Where `evaluate` writes what it has measured in a step."""
    return metrics / f"driving_{step}.json"


def _driving(path: Path) -> dict[tuple[str, str], Performance]:
    """In the order of the strategies and conditions, those that there are."""
    if not path.exists():
        return {}
    file = MetricsFile(path)
    there = _object(json.loads(path.read_text()))
    driving = {
        (str(strategy), condition): file.record(Performance, strategy, condition)
        for strategy in DRIVING
        for condition in CONDITIONS
        if condition in _object(there.get(strategy))
    }
    if not driving:
        raise ValueError(f"{path}: no strategy's drives, expected some of {', '.join(DRIVING)}")
    return driving


def _object(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
