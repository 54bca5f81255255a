"""Metrics of a made-up run of three iterations, and drives to make others from."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.evaluation.drives import table, write_drives
from pipeline.evaluation.writing import write_metrics, write_rows
from pipeline.metric import QUALITY, SPENT
from pipeline.output import write_file
from pipeline.runs import Comparison, read_params

ROOT = Path(__file__).parents[2]
COMPARISON = Comparison.of(read_params(ROOT / "scales/experiment.yaml"))
TRACKS = ("spruce", "willow", "yew")
CARS = 40
CONDITIONS = [
    {"condition": name, "name": "driving", "laps": 3.0, "tracks": ",".join(TRACKS)}
    for name in ("no_traffic", "traffic")
]
# (laps, damage, share driven by the reference) of iterations 0 to 3
GOOD: dict[tuple[str, int], tuple[tuple[float, float, float], ...]] = {
    ("naive", 0): ((1.4, 0, 0), (2.2, 0, 0), (3.0, 0, 0), (3.0, 0, 0)),
    ("naive", CARS): ((0.5, 40, 0), (1.1, 12, 0), (2.4, 6, 0), (2.8, 1.5, 0)),
    ("safe", 0): ((3.0, 0, 0.2), (3.0, 0, 0.15), (3.0, 0, 0.1), (3.0, 0, 0.08)),
    ("safe", CARS): ((2.9, 3, 0.4), (3.0, 1, 0.3), (3.0, 0.5, 0.2), (3.0, 0, 0.12)),
}


def outcome(**changes: Any) -> dict[str, Any]:
    """A drive that left the road half-way round the second lap."""
    values: dict[str, Any] = {
        "scenario": "yew",
        "condition": "traffic" if changes.get("traffic") else "no_traffic",
        "traffic": 0.0,
        "strategy": "naive",
        "start": 0,
        "laps": 1.5,
        "distance_m": 900.0,
        "damage": 0.0,
        "touches": 0.0,
        "frames": 500,
        "takeover_frames": 0,
        "primary_frames": 500,
        "takeovers": 0,
        "switches": 0,
        "deviation_sum": 5.0,
        "off_road": 1.0,
        "ended": "road left",
        "primary": "0" * 64,
        "begun_with": "0" * 64,
        "processor": "made up",
    }
    return values | changes


def drives(iteration: int, plan: Mapping = GOOD) -> pd.DataFrame:
    """Two starts on each track, strategy and condition; yew goes as planned, the others better."""
    return table(
        _drive(track, traffic, strategy, start, *levels[iteration])
        for (strategy, traffic), levels in plan.items()
        for track in TRACKS
        for start in range(2)
    )


def _drive(
    track: str, traffic: int, strategy: str, start: int, laps: float, damage: float, share: float
) -> dict[str, Any]:
    laps = laps if track == "yew" else min(laps + 0.3 * start + 0.2, 3.0)
    frames = round(300 * laps)
    takeover_frames = round(frames * share)
    primary_frames = frames - takeover_frames
    return outcome(
        scenario=track,
        traffic=float(traffic),
        strategy=strategy,
        start=start,
        laps=float(laps),
        damage=float(damage),
        frames=frames,
        takeover_frames=takeover_frames,
        primary_frames=primary_frames,
        takeovers=takeover_frames // 5,
        switches=2 * (takeover_frames // 5),
        deviation_sum=primary_frames * 0.05 / (1 + laps),
        off_road=float(laps < 3.0),
        ended="road left" if laps < 3.0 else "laps done",
    )


def quality(auroc: float | None) -> dict[str, Any]:
    return {
        "tau": 0.0025,
        "frames": 40,
        "auroc": auroc,
        "recall": None if auroc is None else auroc - 0.3,
        "precision": None if auroc is None else auroc - 0.2,
        "share_unsafe": 0.2,
        "share_predicted_unsafe": 0.15,
        "average_precision": auroc,
        "calibration_error": 0.1,
        "calibration": [[0.1, 0.15, 30], [0.6, 0.7, 10]],
    }


def write_run(metrics: Path, plan: Mapping = GOOD, iterations: int = 3) -> Path:
    """Every file that the report reads."""
    runs = COMPARISON.model_dump_json(exclude_defaults=True)
    write_file(metrics / "runs.json", runs.encode())
    for i in range(iterations + 1):
        step = f"safedagger_{i}" if i else "0"
        write_drives(metrics / f"drives_{step}.csv", drives(i, plan))
        ledger = {
            "frames_driven": 3600 + 10 * i,
            "queries": 3600 if i == 0 else 1400 - 300 * i,
            "frames_selected": 3600 if i == 0 else 1400 - 300 * i,
            "frames_trained": 3600 + sum(1400 - 300 * j for j in range(1, i + 1)),
            "takeover": 1.0 if i == 0 else (1400 - 300 * i) / (3600 + 10 * i),
        }
        write_metrics(metrics / f"driving_{step}.json", {"rows": CONDITIONS})
        write_rows(metrics / f"ledger_D_{step}.json", ledger, SPENT)
        write_rows(metrics / f"safety_{step}.json", quality(0.9), QUALITY)
        if i > 0:
            write_rows(metrics / f"rollout_{step}.json", quality(0.8 - i / 50), QUALITY)
    d_safe = {"frames_selected": 1201, "frames_trained": 1201, "takeover": 1.0}
    d_safe |= {"frames_driven": 1201, "queries": 1201}
    write_rows(metrics / "ledger_D_safe.json", d_safe, SPENT)
    errors = {"trained_on": {"share_safe": 0.95}, "tau": 0.0025, "share": 0.777}
    errors |= {"held_out": {"share_safe": 0.8, "tau_for_share": 0.0018}}
    write_metrics(metrics / "errors.json", errors)
    return metrics
