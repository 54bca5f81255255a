"""Algorithm 1 for real, tiny: `dvc repro` from nothing, end to end, on the project's own dvc.yaml."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.content import processor, run_hashes

HOUSE = Path(__file__).parents[2]
HELD = HOUSE / "tests" / "held" / "tiny.json"
OF_THE_REFERENCE = ("D_0", "D_safe", "D_held", "new_supervised_1")
STEPS = ["safedagger_1", "safedagger_2", "dagger_1", "supervised_1"]
LABELS = {"tau": 0.0025, "horizon": 0, "horizon-mode": "last"}
ALL = "naive,safe,optimal"
TINY = {
    "tracks": {"training": "alder,birch", "test": "yew"},
    "rollouts": {
        "safedagger_1": {"iteration": 1, "primary": "0", "safety": "0", "queries": 12},
        "safedagger_2": {
            "iteration": 2,
            "primary": "safedagger_1",
            "safety": "safedagger_1",
            "queries": 12,
        },
    },
    "dagger": {
        "dagger_1": {"iteration": 1, "previous": "0", "beta": 0, "frames": 30, "sample": 12}
    },
    "supervised": {"supervised_1": {"iteration": 1, "episodes": 2}},
    "steps": {
        step: {"previous": "safedagger_1" if step == "safedagger_2" else "0", "passes": 128}
        for step in STEPS
    },
    "from-scratch": {"scratch_2": {"data": "safedagger_2", "passes": 128}},
    "safeties": {
        step: {"primary": step, "data": step, "labels": LABELS, "strategies": ALL}
        for step in ["0", *STEPS]
    }
    | {
        "scratch_2": {
            "primary": "scratch_2",
            "data": "safedagger_2",
            "labels": LABELS,
            "strategies": "naive",
        },
        "ahead": {
            "primary": "0",
            "data": "0",
            "labels": LABELS | {"horizon": 0.5, "horizon-mode": "max"},
            "strategies": "safe",
        },
    },
    "ledgers": {"0": {"driven": "D_0"}, "safe": {"driven": "D_safe"}}
    | {
        step: {"driven": f"{'new' if step == 'supervised_1' else 'rollout'}_{step}"}
        for step in STEPS
    },
    "contact-sheet": {"frames": 2},
    "film": {"traffic": 2, "seconds": 2},
    "drive": {"traffic": 3},
    "d-0": {"episodes": 4, "seconds": 1},
    "d-safe": {"episodes": 4, "seconds": 1},
    "primary-0": {"passes": 192},
    "train-primary": {"channels": 4},
    "train-safety": {"passes": 256, "hidden": 8, "cut": 1.0},
    "rollout": {"frames": 60, "seconds": 2},
    "rollout-dagger": {"seconds": 2},
    "collect-supervised": {"seconds": 1},
    "evaluate": {"traffic": 2, "laps": 0.05, "seconds": 2, "starts": 1},
}
LOOPS = ("rollouts", "dagger", "supervised", "steps", "from-scratch", "safeties", "ledgers")


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout's pipeline with tiny parameters, reproduced."""
    return reproduced(tmp_path_factory.mktemp("house"), TINY)


def reproduced(root: Path, tiny: dict) -> Path:
    """The project's own pipeline, with other parameters, from nothing to the report."""
    for name in ("pipeline", "stages", "dvc.yaml"):
        (root / name).symlink_to(HOUSE / name)
    params = yaml.safe_load((HOUSE / "params.yaml").read_text())
    for group, values in tiny.items():
        keep = group not in LOOPS
        params[group] = params[group] | values if keep else values
    (root / "params.yaml").write_text(yaml.safe_dump(params))
    dvc(root, "init", "--no-scm")
    settings = (HOUSE / ".dvc" / "config").read_text()
    (root / ".dvc" / "config").write_text(settings.replace("[core]", "[core]\n    no_scm = true"))
    dvc(root, "repro")
    return root


def dvc(root: Path, *arguments: str) -> str:
    """What a DVC command prints; the stages it runs find this Python's commands first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [Path(sys.executable).parent / "dvc", *arguments],
        cwd=root,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def metric(house: Path, name: str) -> dict:
    return json.loads((house / "cards" / "metrics" / "seed_0" / f"{name}.json").read_text())


def test_the_run_is_what_it_was(house: Path) -> None:
    """While the house is rebuilt. On another processor, what no network had a part in."""
    runs = json.loads(HELD.read_text())
    held = runs.get(processor())
    if held is None:
        places = tuple(f"datasets/{name}/" for name in OF_THE_REFERENCE)
        held = {k: v for k, v in next(iter(runs.values())).items() if k.startswith(places)}
    found = run_hashes(house)
    assert {name: found.get(name) for name in held} == held


def test_what_was_selected_is_what_was_queried_is_what_was_merged(house: Path) -> None:
    from pipeline.data.dataset import Dataset

    before = len(Dataset.open(house / "datasets" / "D_0"))
    for step in ("safedagger_1", "safedagger_2"):
        raw = Dataset.open(house / "datasets" / f"rollout_{step}")
        selected = Dataset.open(house / "datasets" / f"new_{step}")
        after = len(Dataset.open(house / "datasets" / f"D_{step}"))
        queries = int(raw.column("queried").sum())
        assert queries == len(selected) == after - before
        assert metric(house, f"ledger_D_{step}")["queries"] == queries
        before = after


def test_dagger_pays_for_all_that_it_collects_and_trains_on_a_sample(house: Path) -> None:
    ledger = metric(house, "ledger_D_dagger_1")
    assert ledger["queries"] == ledger["frames_driven"] == 30
    assert ledger["frames_selected"] == 12
    assert ledger["takeover"] == 0


def test_supervised_learning_pays_for_what_the_reference_drives(house: Path) -> None:
    ledger = metric(house, "ledger_D_supervised_1")
    assert ledger["queries"] == ledger["frames_driven"] == ledger["frames_selected"] == 20
    assert ledger["takeover"] == 1


def test_all_strategies_are_evaluated(house: Path) -> None:
    of_all = {"tracks", "most_laps"}
    assert set(metric(house, "driving_dagger_1")) == of_all | {"naive", "safe", "optimal"}
    assert set(metric(house, "driving_ahead")) == of_all | {"safe"}


def test_a_primary_can_be_trained_from_scratch_on_the_same_data(house: Path) -> None:
    weights = [
        (house / "models" / name / "model.safetensors").read_bytes()
        for name in ("primary_scratch_2", "primary_safedagger_2")
    ]
    assert weights[0] != weights[1]
    assert set(metric(house, "driving_scratch_2")) == {"tracks", "most_laps", "naive"}


def test_the_report_stands_on_the_metrics(house: Path) -> None:
    report = (house / "cards" / "report.md").read_text()
    for run in ("SafeDAgger", "DAgger", "supervised"):
        assert f"| {run} | 1 |" in report
    assert "On D_2, " in report
    assert "DAgger, seed 0: no iteration 2, 3." in report


def test_every_dataset_and_policy_has_a_card_that_says_what_made_it(house: Path) -> None:
    for kind, verb in (("datasets", "merge"), ("models", "train-primary")):
        made = {path.name for path in (house / kind).iterdir() if path.is_dir()}
        cards = {path.stem: path.read_text() for path in (house / "cards" / kind).glob("*.md")}
        assert set(cards) == made
        name = "D_safedagger_2" if kind == "datasets" else "primary_safedagger_2"
        assert f"safedagger {verb}" in cards[name]
        assert not [card for card in cards.values() if str(house) in card or "Not known" in card]


def test_pictures_are_drawn(house: Path) -> None:
    for picture in ("errors/seed_0", "frames/seed_0", "figures/result"):
        assert (house / "cards" / f"{picture}.png").read_bytes().startswith(b"\x89PNG")
    assert (house / "cards" / "film.gif").read_bytes().startswith(b"GIF89a")


def test_tau_can_be_chosen_by_share(house: Path) -> None:
    errors = metric(house, "errors")
    assert errors["held_out"]["frames"] == 40
    assert errors["share"] == 0.777
    assert (errors["held_out"]["tau_for_share"] <= errors["tau"]) == (
        errors["held_out"]["share_safe"] >= errors["share"]
    )


def test_a_second_repro_does_nothing(house: Path) -> None:
    assert "up to date" in dvc(house, "repro")


def test_a_change_in_iteration_2_runs_only_what_follows(house: Path) -> None:
    params = house / "params.yaml"
    before = params.read_text()
    changed = yaml.safe_load(before)
    changed["steps"]["safedagger_2"]["passes"] = 64
    params.write_text(yaml.safe_dump(changed))
    try:
        plan = dvc(house, "repro", "--dry")
    finally:
        params.write_text(before)
    stages = {line.split("'")[1] for line in plan.splitlines() if line.startswith("Running stage")}
    assert "train-primary@safedagger_2" in stages
    assert {name.split("@")[-1] for name in stages} <= {"safedagger_2", "cards", "report"}


ONLY = ("0", "safedagger_1")
GOOD = TINY | {
    **{"dagger": {}, "supervised": {}, "from-scratch": {}},
    **{
        group: {k: v for k, v in TINY[group].items() if k in ONLY}
        for group in ("steps", "safeties")
    },
    "rollouts": {"safedagger_1": TINY["rollouts"]["safedagger_1"]},
    "ledgers": {k: v for k, v in TINY["ledgers"].items() if k in (*ONLY, "safe")},
    "train-safety": TINY["train-safety"] | {"cut": 0},
}


def test_a_rollout_in_which_nothing_was_unsafe_does_not_stop_the_loop(tmp_path: Path) -> None:
    """With a cut of 0 nothing is: D_1 is D_0, no query was paid, and all that follows runs."""
    from pipeline.data.dataset import Dataset

    house = reproduced(tmp_path, GOOD)
    new, before, after = (
        Dataset.open(house / "datasets" / name)
        for name in ("new_safedagger_1", "D_0", "D_safedagger_1")
    )
    assert len(new) == 0
    assert [file.read_bytes() for file in before.data_files] == [
        file.read_bytes() for file in after.data_files
    ]
    ledger = metric(house, "ledger_D_safedagger_1")
    assert ledger["queries"] == ledger["frames_selected"] == ledger["takeover"] == 0
    assert (ledger["frames_driven"], ledger["frames_trained"]) == (60, len(before))
    assert (house / "models" / "safety_safedagger_1").is_dir()
    card = (house / "cards" / "datasets" / "new_safedagger_1.md").read_text()
    assert "It has no frames" in card
    assert (house / "cards" / "report.md").is_file()
