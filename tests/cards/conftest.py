"""A tiny house: real datasets, policies and metrics, and the cards of them all."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Lineage, Recipe
from pipeline.data.merging import merge
from pipeline.data.selecting import select
from pipeline.data.writing import write_dataset
from pipeline.driving.features import ROBOT_TYPE
from pipeline.evaluation.drives import table, write_drives
from pipeline.evaluation.writing import write_metrics, write_rows
from pipeline.metric import QUALITY
from pipeline.policies.loading import policy_lineage, weights_sha256
from tests.command import run
from tests.drives import save_untrained
from tests.episodes import JUDGED, LABELS, random_episode, write
from tests.evaluation.made_up import outcome
from tests.evaluation.written import CONDITIONS

ALDER, BIRCH = "drive on alder with 3 other cars", "drive on birch with 0 other cars"
CARDS = "cards --action-repeat 3"
PLACES = "--datasets {0}datasets --models {0}models --metrics {0}metrics"
OUTPUTS = "--dataset-cards {0}/datasets --model-cards {0}/models"


@pytest.fixture(scope="session")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The house, without cards. Do not change it."""
    root = tmp_path_factory.mktemp("cards") / "house"
    d_0 = _write_demonstrations(root / "datasets")
    primary, safety = (root / f"models/{name}_0" for name in ("primary", "safety"))
    save_untrained(primary, safety, cut=0.6)
    _tell(primary, Recipe("primary", {"channels": 2}, [d_0.lineage]))
    _tell(safety, Recipe("safety", {"tau": 0.05}, [policy_lineage(primary), d_0.lineage]))
    _write_rollout(root / "datasets", d_0, [policy_lineage(primary), policy_lineage(safety)])
    _write_metrics(root / "metrics", weights_sha256(primary))
    return root


@pytest.fixture
def house(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the house to stand in."""
    shutil.copytree(original, tmp_path / "house")
    monkeypatch.chdir(tmp_path / "house")
    return tmp_path / "house"


@pytest.fixture
def make_cards(house: Path) -> Callable[..., Path]:
    """Makes the cards of the house; returns the folder that they are in."""

    def make(folder: str = "cards") -> Path:
        assert run(f"{CARDS} {PLACES.format('')} {OUTPUTS.format(folder)}") == 0
        return house / folder

    return make


@pytest.fixture(scope="session")
def finished(original: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The house with its cards. Do not change it."""
    house = shutil.copytree(original, tmp_path_factory.mktemp("cards") / "finished")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(house)
        assert run(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}") == 0
    return house


def _tell(folder: Path, recipe: Recipe) -> None:
    recipe.lineage(weights_sha256(folder)).write(folder)


def _write_demonstrations(folder: Path) -> Dataset:
    rng = np.random.default_rng(0)
    shown = [
        random_episode(rng, 4, task=ALDER, episode=0, reference_only=True),
        random_episode(rng, 3, task=BIRCH, episode=1, reference_only=True),
    ]
    return write(folder / "D_0", shown, iteration=0)


def _write_rollout(folder: Path, d_0: Dataset, policies: list[Lineage]) -> None:
    rng = np.random.default_rng(1)
    driven = [
        random_episode(rng, 9, task=ALDER, iteration=1, episode=0),
        random_episode(rng, 8, task=BIRCH, iteration=1, episode=1),
    ]
    endings = [
        {"episode": n, "touches": 1.0, "off_road": 1.0 - n, "ended": ended, "put_back": 1 - n}
        for n, ended in enumerate(("road left", "budget"))
    ]
    driven = [replace(drive, ending=end) for drive, end in zip(driven, endings, strict=True)]
    arguments = {
        "task": "driving",
        "iteration": 1,
        **JUDGED,
        "labels": LABELS | {"tau": 0.05, "measure": "steering-and-brake"},
    }
    recipe = Recipe("rollout", arguments, policies)
    write_dataset(folder / "rollout_1", driven, recipe, fps=10, robot=ROBOT_TYPE)
    select(Dataset.open(folder / "rollout_1"), folder / "new_1")
    merge([d_0, Dataset.open(folder / "new_1")], folder / "D_1")


def _write_metrics(folder: Path, primary: str) -> None:
    drives = table([outcome(), outcome(traffic=3.0, damage=6.0)]).assign(primary=primary)
    write_drives(folder / "drives_0.csv", drives)
    write_metrics(folder / "driving_0.json", {"rows": CONDITIONS})
    quality = {"tau": 0.0025, "auroc": 0.75, "recall": 0.6, "precision": 0.5, "frames": 40}
    quality |= {"share_unsafe": 0.25, "share_predicted_unsafe": 0.3}
    quality |= {"average_precision": 0.55, "calibration_error": 0.1}
    write_rows(folder / "safety_0.json", quality, QUALITY)
