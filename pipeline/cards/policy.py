"""What there is to say of a policy, read from its directory and from what was measured of it."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from torch import Tensor

from pipeline.driving.metrics import METRICS
from pipeline.driving.tracks import TEST
from pipeline.evaluation.files import Quality, Rows, read_json
from pipeline.evaluation.reading import read_driven
from pipeline.evaluation.summary import measure
from pipeline.metric import shown
from pipeline.policies.loading import (
    SAFETY_TYPE,
    load_primary,
    load_safety,
    read_config,
    weights_sha256,
)
from pipeline.registry import PRIMARIES
from pipeline.rollout.strategies import DRIVING


def policy_facts(path: Path, metrics: Path) -> dict[str, Any]:
    """A policy, whose weights are checked to be whole and to fit, and what it is worth: by
    drives_<step>.csv, driving_<step>.json and safety_<step>.json in the folder `metrics`, where its step
    is what its name says after its kind, "0" of primary_0. ValueError where files are missing, of
    another kind of policy, or do not fit.

    Returns:
        "kind", LeRobot's name for it; "config"; "layers", each with its name, the shape of its weights
            (empty for several layers) and its parameters.
        "driving", by strategy and condition, of a primary and its safety policy together: METRICS;
            "tracks" and "most", where and how far they drove at most; "held_out", of a safety policy:
            `files.Quality`. Empty where that was of another policy, of another seed's say, or nobody
            knows of which.
    """
    config = read_config(path, *PRIMARIES, SAFETY_TYPE)
    is_safety = config.kind == SAFETY_TYPE
    weights = (load_safety if is_safety else load_primary)(path).state_dict()
    primary = config.content["primary_sha256"] if is_safety else weights_sha256(path)
    return {
        "name": path.name,
        "kind": config.kind,
        "is_safety": is_safety,
        "config": dict(config.content),
        "layers": _layers(weights),
        **_measured(metrics, path.name.partition("_")[2], primary, is_safety=is_safety),
    }


def _layers(weights: Mapping[str, Tensor]) -> list[dict[str, Any]]:
    """In the order of the network; its outputs as one."""
    layers: dict[str, dict[str, Any]] = {}
    for key, tensor in weights.items():
        outputs = key.startswith("outputs.")
        name = "outputs" if outputs else key.rpartition(".")[0]
        layer = layers.setdefault(name, {"name": name, "shape": [], "parameters": 0})
        layer["parameters"] += tensor.numel()
        if key.endswith("weight") and not outputs:
            layer["shape"] = list(tensor.shape)
    return list(layers.values())


def _measured(metrics: Path, step: str, primary: str, *, is_safety: bool) -> dict[str, Any]:
    """Of a step, where it was driven by a primary of this SHA-256."""
    found: dict[str, Any] = {"driving": [], "tracks": [], "most": {}, "held_out": None}
    if not (metrics / f"drives_{step}.csv").is_file():
        return found | {"on_test_tracks": False}
    drives = read_driven(metrics, step)
    if set(drives.primary) == {primary}:
        found["tracks"] = drives.scenario.unique().tolist()
        most = float(drives["task.laps"].max())
        found["most"] = {"laps": most} if math.isfinite(most) else {}
        found["driving"] = [
            {"strategy": str(strategy), "condition": condition, "drives": len(driven)}
            | measure(driven, shown(METRICS, "cards"))
            for strategy in DRIVING
            for condition in drives.condition.unique()
            if len(
                driven := drives[(drives.strategy == strategy) & (drives.condition == condition)]
            )
        ]
        if is_safety and (metrics / f"safety_{step}.json").is_file():
            (held_out,) = read_json(metrics / f"safety_{step}.json", Rows[Quality]).rows
            found["held_out"] = held_out.model_dump()
    return found | {"on_test_tracks": TEST.keys() >= set(found["tracks"])}
