"""A tiny house: real datasets, policies and metrics, a dvc.lock, and the cards of them all."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from pipeline.data.merging import merge
from pipeline.data.reading import read_episodes
from pipeline.data.selecting import select_unsafe
from pipeline.data.writing import write_dataset
from pipeline.evaluation.summary import summarise
from pipeline.evaluation.writing import write_metrics
from pipeline.policies.loading import weights_sha256
from pipeline.policies.network import PrimaryNetwork, SafetyNetwork, feature_size
from pipeline.policies.primary import PrimaryConfig, PrimaryPolicy
from pipeline.policies.safety import SafetyConfig, SafetyPolicy
from stages.cards import cards as run_stage
from tests.episodes import random_episode
from tests.evaluation.sample import outcome

ALDER, BIRCH = "drive on alder with 3 other cars", "drive on birch with 0 other cars"
MADE = {
    "datasets/D_0": ("collect datasets/D_0 --purpose D_0 --iteration 0", ["pipeline/data"]),
    "datasets/rollout_1": (
        "rollout models/primary_0 models/safety_0 datasets/rollout_1 --iteration 1",
        ["models/primary_0", "models/safety_0", "pipeline/world"],
    ),
    "datasets/new_1": (
        "select datasets/rollout_1 datasets/new_1 --cut 0.5",
        ["datasets/rollout_1"],
    ),
    "datasets/D_1": (
        "merge datasets/D_0 datasets/new_1 datasets/D_1",
        ["datasets/D_0", "datasets/new_1"],
    ),
    "models/primary_0": ("train-primary datasets/D_0 models/primary_0", ["datasets/D_0"]),
    "models/safety_0": (
        "train-safety models/primary_0 datasets/D_0 datasets/D_0 models/safety_0",
        ["datasets/D_0", "models/primary_0"],
    ),
    "metrics/driving_0.json": (
        "evaluate models/primary_0 models/safety_0 --tracks yew",
        ["models/primary_0", "models/safety_0"],
    ),
}
"""By output: the command, and what it reads."""


@pytest.fixture(scope="session")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The house, without cards. Do not change it."""
    root = tmp_path_factory.mktemp("cards") / "house"
    _write_datasets(root / "datasets")
    generator = torch.Generator().manual_seed(0)
    primary = PrimaryNetwork(2, generator=generator)
    PrimaryPolicy(PrimaryConfig(channels=2), primary).save_pretrained(root / "models/primary_0")
    safety = SafetyNetwork(feature_size(2), 4, generator=generator)
    watched = weights_sha256(root / "models/primary_0")
    config = SafetyConfig(primary_sha256=watched, channels=2, hidden=4, cut=0.6)
    SafetyPolicy(config, safety).save_pretrained(root / "models/safety_0")
    _write_metrics(root / "metrics")
    stages = {
        f"stage-{number}": {
            "cmd": f"safedagger {command}",
            "deps": [{"path": path} for path in read],
            "outs": [{"path": out}],
        }
        for number, (out, (command, read)) in enumerate(MADE.items())
    }
    (root / "dvc.lock").write_text(yaml.safe_dump({"schema": "2.0", "stages": stages}))
    return root


@pytest.fixture
def house(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the house to stand in."""
    shutil.copytree(original, tmp_path / "house")
    monkeypatch.chdir(tmp_path / "house")
    return tmp_path / "house"


@pytest.fixture
def make_cards(house: Path) -> Callable[..., Path]:
    """The stage, called in the house; returns the folder of its outputs."""

    def make(folder: str = "cards", *, lock: Path | None = Path("dvc.lock")) -> Path:
        run_stage(
            datasets=Path("datasets"),
            models=Path("models"),
            metrics=Path("metrics"),
            tau=0.0025,
            record_every=3,
            dataset_cards=Path(folder, "datasets"),
            model_cards=Path(folder, "models"),
            lock=lock,
        )
        return house / folder

    return make


def _write_datasets(folder: Path) -> None:
    rng = np.random.default_rng(0)
    shown = [
        random_episode(rng, 4, task=ALDER, episode=0, reference_only=True),
        random_episode(rng, 3, task=BIRCH, episode=1, reference_only=True),
    ]
    driven = [
        random_episode(rng, 9, task=ALDER, iteration=1, episode=0),
        random_episode(rng, 8, task=BIRCH, iteration=1, episode=1),
    ]
    write_dataset(folder / "D_0", shown, record_every=3)
    write_dataset(folder / "rollout_1", driven, record_every=3)
    unsafe = select_unsafe(read_episodes(folder / "rollout_1"), 0.5)
    write_dataset(folder / "new_1", unsafe, record_every=3)
    merge([folder / "D_0", folder / "new_1"], folder / "D_1")


def _write_metrics(folder: Path) -> None:
    drives = [outcome(), outcome(traffic=3, damage=6.0)]
    evaluated = {"tracks": ["yew", "random:9"], "most_laps": 0.5, **summarise(drives)}
    write_metrics(folder / "driving_0.json", evaluated)
    quality = {"auroc": 0.75, "recall": 0.6, "precision": 0.5, "share_unsafe": 0.25}
    held_out = quality | {"share_predicted_unsafe": 0.3, "frames": 40}
    write_metrics(folder / "safety_0.json", {"tau": 0.0025, "held_out": held_out})
