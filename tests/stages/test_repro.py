"""Algorithm 1 for real, tiny: `dvc repro` from nothing, end to end, on the project's own dvc.yaml."""

import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from pipeline.evaluation.drives import read_drives
from tests.command import run
from tests.content import processor, run_hashes

HOUSE = Path(__file__).parents[2]
HELD = HOUSE / "tests" / "held" / "tiny.json"
OF_THE_REFERENCE = ("D_0", "D_safe", "D_held", "new_supervised_1")
EACH = {
    "samples": [128],
    "protocol": "anywhere",
    "tau": [0.0025],
    "driven_by": "naive,safe,optimal",
    "words": "One.",
    "colour": "black",
    "marker": "o",
}
RUNS: dict[str, dict[str, Any]] = {
    "safedagger": EACH
    | {"strategy": "safedagger", "name": "SafeDAgger", "queries": [12, 12], "from_scratch": [2]},
    "dagger": EACH | {"strategy": "dagger", "name": "DAgger", "frames": [30], "sample": [12]},
    "supervised": EACH
    | {"strategy": "supervised", "name": "supervised", "episodes": [2], "protocol": "briefly"},
    "ahead": EACH
    | {"strategy": "safedagger", "name": "Ahead", "variant_of": "safedagger", "queries": [12]}
    | {"horizon": 0.5, "horizon_mode": "max", "driven_by": "safe"},
    "audited": EACH
    | {"strategy": "safedagger", "name": "Audited", "variant_of": "safedagger", "queries": [12]}
    | {"audit": 0.5, "set_aside": 0.75, "driven_by": "safe"},
    "more": EACH | {"strategy": "training", "name": "more training", "driven_by": ""},
}
TINY: dict[str, Any] = {
    "runs": RUNS,
    "tracks": {"training": "alder,birch", "test": "yew"},
    "contact-sheet": {"frames": 2},
    "film": {"traffic": 2, "seconds": 2},
    "drive": {"traffic": 3},
    "d-0": {"episodes": 4, "seconds": 1},
    "d-safe": {"episodes": 4, "seconds": 1},
    "primary-0": {"samples": 192},
    "train-primary": {"channels": 4},
    "train-safety": {"samples": 256, "hidden": 8, "cut": 1.0},
    "rollout": {"frames": 60},
    "protocols": {
        name: {"seconds": seconds, "offset-spread": 0.3, "angle-spread": 0.03}
        for name, seconds in (("anywhere", 2), ("briefly", 1))
    },
    "reliability": {"ends": "random:1-2", "between": "random:1"},
    "lap": {"traffic": 2, "laps": 0.05, "seconds": 2},
    "evaluate": {"traffic": 2, "laps": 0.05, "seconds": 2, "starts": 1},
}


# What Python runs first of all: each stage writes down which of our modules it loads, in whichever
# process.
WATCH = """
import os, sys
class Seen:
    def find_spec(name, path=None, target=None):
        if name.startswith("pipeline."):
            with open(os.environ["LOADED"], "a") as log:
                log.write(os.environ["DVC_STAGE"] + " " + name + "\\n")
if "DVC_STAGE" in os.environ:
    sys.meta_path.insert(0, Seen)
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout's pipeline with tiny parameters, reproduced."""
    root, watch = tmp_path_factory.mktemp("house"), tmp_path_factory.mktemp("watch")
    (watch / "sitecustomize.py").write_text(WATCH)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(watch), prepend=os.pathsep)
        patch.setenv("LOADED", str(root / "loaded.txt"))
        return reproduced(root, TINY)


def reproduced(root: Path, tiny: dict) -> Path:
    """The project's own pipeline, with other parameters, from nothing to the report."""
    for name in ("pipeline", "stages", "dvc.yaml"):
        (root / name).symlink_to(HOUSE / name)
    for name in ("curves", "frames"):
        (root / "cards" / name).mkdir(parents=True)
    plan(root, tiny)
    dvc(root, "init", "--no-scm")
    settings = (HOUSE / ".dvc" / "config").read_text()
    (root / ".dvc" / "config").write_text(settings.replace("[core]", "[core]\n    no_scm = true"))
    dvc(root, "repro")
    return root


def plan(root: Path, tiny: dict[str, Any]) -> None:
    """Write the parameters and the loops."""
    params = yaml.safe_load((HOUSE / "params.yaml").read_text())
    for group, values in tiny.items():
        params[group] = params[group] | values if group != "runs" else values
    (root / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    assert run(f"plan --params {root}/params.yaml --loops {root}/loops.yaml") == 0


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


def ledger_of(house: Path, step: str) -> dict:
    (row,) = metric(house, f"ledger_D_{step}")["rows"]
    return row


def test_the_run_is_what_it_was(house: Path) -> None:
    """While the house is rebuilt. On another processor, what no network had a part in."""
    runs = json.loads(HELD.read_text())
    held = runs.get(processor())
    if held is None:
        places = tuple(f"datasets/{name}/" for name in OF_THE_REFERENCE)
        held = {k: v for k, v in next(iter(runs.values())).items() if k.startswith(places)}
    found = run_hashes(house)
    assert {name: found.get(name) for name in held} == held


def test_stages_depend_on_the_code_that_they_run(house: Path) -> None:
    """No more and no less, in whichever of their processes: a file, or a folder of them. What every
    command loads before it knows which one it is does not count.
    """
    code = "import stages.__main__, sys; print(*sys.modules)"
    start = subprocess.run([sys.executable, "-c", code], cwd=HOUSE, capture_output=True, text=True)
    loaded: dict[str, set[str]] = defaultdict(set)
    for line in (house / "loaded.txt").read_text().splitlines():
        stage, module = line.split()
        file = f"{module.replace('.', '/')}.py"
        if (HOUSE / file).is_file() and module not in start.stdout.split():
            loaded[stage.partition("@")[0]].add(file)
    stages = yaml.safe_load((HOUSE / "dvc.yaml").read_text())["stages"]
    for name, stage in stages.items():
        told = stage.get("do", stage)["deps"]
        deps = {place for place in told if place.startswith("pipeline")}
        used = {dep for dep in deps for f in loaded[name] if f == dep or f.startswith(f"{dep}/")}
        covered = {f for f in loaded[name] for dep in deps if f == dep or f.startswith(f"{dep}/")}
        assert (name, deps - used, loaded[name] - covered) == (name, set(), set())
        own = f"stages/{stage.get('do', stage)['cmd'].split()[1].replace('-', '_')}.py"
        assert own in told, name


def test_what_was_selected_is_what_was_queried_is_what_was_merged(house: Path) -> None:
    from pipeline.data.dataset import Dataset

    before = len(Dataset.open(house / "datasets" / "D_0"))
    for step in ("safedagger_1", "safedagger_2"):
        raw = Dataset.open(house / "datasets" / f"rollout_{step}")
        selected = Dataset.open(house / "datasets" / f"new_{step}")
        after = len(Dataset.open(house / "datasets" / f"D_{step}"))
        queries = int(raw.column("queried").sum())
        assert queries == len(selected) == after - before
        assert ledger_of(house, step)["queries"] == queries
        before = after


def test_dagger_pays_for_all_that_it_collects_and_trains_on_a_sample(house: Path) -> None:
    ledger = ledger_of(house, "dagger_1")
    assert ledger["queries"] == ledger["frames_driven"] == 30
    assert ledger["frames_selected"] == 12
    assert ledger["takeover"] == 0


def test_supervised_learning_pays_for_what_the_reference_drives(house: Path) -> None:
    ledger = ledger_of(house, "supervised_1")
    assert ledger["queries"] == ledger["frames_driven"] == ledger["frames_selected"] == 20
    assert ledger["takeover"] == 1


def test_all_strategies_are_evaluated(house: Path) -> None:
    driven = {"dagger_1": {"naive", "safe", "optimal"}, "ahead_0": {"safe"}}
    driven["scratch_2"] = {"naive", "safe"}
    for step, strategies in driven.items():
        drives = pd.read_csv(house / f"cards/metrics/seed_0/drives_{step}.csv")
        assert set(drives.strategy) == strategies
        shown = strategies - {"optimal"}
        assert set(metric(house, f"driving_{step}")) == {"rows"} | shown


def test_every_primary_is_counted_on_alone(house: Path) -> None:
    """On more tracks at the end of a loop than between, in both conditions."""
    metrics = house / "cards" / "metrics" / "seed_0"
    drives = {path.stem: read_drives(path) for path in metrics.glob("reliability_*.csv")}
    ends = ("0", "safedagger_2", "dagger_1", "supervised_1", "ahead_1", "more_1")
    ends += ("audited_0", "audited_1")
    assert {name: len(table) for name, table in drives.items()} == {
        "reliability_safedagger_1": 2,
        **{f"reliability_{step}": 4 for step in ends},
    }
    assert all((table.strategy == "naive").all() for table in drives.values())


def test_training_alone_goes_on_with_the_data_of_the_supervised_stage(house: Path) -> None:
    more, first = (
        json.loads((house / f"models/primary_{step}/safedagger.json").read_text())
        for step in ("more_1", "0")
    )
    assert set(more["made"][more["sha256"]]["parents"]) == set(first["made"])


def test_a_primary_can_be_trained_from_scratch_on_the_same_data(house: Path) -> None:
    weights = [
        (house / "models" / name / "model.safetensors").read_bytes()
        for name in ("primary_scratch_2", "primary_safedagger_2")
    ]
    assert weights[0] != weights[1]


def test_the_report_stands_on_the_metrics(house: Path) -> None:
    report = (house / "cards" / "report.md").read_text()
    for name in ("SafeDAgger", "DAgger", "supervised"):
        assert f"| {name} | 1 |" in report
    assert "On D_2, " in report
    assert "No run, seed or picture is missing." not in report


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


def test_the_curves_of_all_trainings_can_be_drawn(house: Path) -> None:
    metrics = house / "cards" / "metrics" / "seed_0"
    curves = {path.stem for path in metrics.glob("curve_*.csv")}
    trained = {path.name for path in (house / "models").iterdir() if path.is_dir()}
    assert {name.removeprefix("curve_") for name in curves} == trained
    rows = (metrics / "curve_safety_0.csv").read_text().splitlines()
    assert rows[0] == "epoch,samples,loss" and rows[-1].split(",")[1] == "256"
    dvc(house, "plots", "show", "--out", str(house / "plots"))
    page = (house / "plots" / "index.html").read_text()
    assert all(f"{name}.csv" in page for name in curves) and '"field": "loss"' in page


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
    before = {name: (house / name).read_text() for name in ("params.yaml", "loops.yaml")}
    plan(house, TINY | {"runs": RUNS | {"safedagger": RUNS["safedagger"] | {"samples": [128, 64]}}})
    try:
        planned = dvc(house, "repro", "--dry")
    finally:
        for name, text in before.items():
            (house / name).write_text(text)
    lines = [line for line in planned.splitlines() if line.startswith("Running stage")]
    stages = {line.split("'")[1] for line in lines}
    assert {"train-primary@safedagger_2", "train-primary-from-scratch@scratch_2"} <= stages
    steps = {name.split("@")[-1] for name in stages}
    assert steps <= {"safedagger_2", "scratch_2", "runs", "cards", "report"}


def test_without_a_run_that_needs_a_safety_policy_there_is_a_pipeline(tmp_path: Path) -> None:
    for name in ("pipeline", "stages", "dvc.yaml"):
        (tmp_path / name).symlink_to(HOUSE / name)
    plan(tmp_path, TINY | {"runs": {"mine": RUNS["dagger"]}})
    dvc(tmp_path, "init", "--no-scm")
    stages = dvc(tmp_path, "stage", "list", "--name-only").split()
    assert "rollout-dagger@mine_1" in stages and "train-safety@mine_1" in stages
    assert not [name for name in stages if name.startswith(("rollout@", "select@", "contact"))]


GOOD = TINY | {
    "runs": {"safedagger": RUNS["safedagger"] | {"queries": [12], "from_scratch": []}},
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
    ledger = ledger_of(house, "safedagger_1")
    assert ledger["queries"] == ledger["frames_selected"] == ledger["takeover"] == 0
    assert (ledger["frames_driven"], ledger["frames_trained"]) == (60, len(before))
    assert (house / "models" / "safety_safedagger_1").is_dir()
    card = (house / "cards" / "datasets" / "new_safedagger_1.md").read_text()
    assert "It has no frames" in card
    assert (house / "cards" / "report.md").is_file()
