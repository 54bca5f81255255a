"""Algorithm 1 for real, tiny: `dvc repro` from nothing, end to end, on the project's own dvc.yaml."""

import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest
import yaml

from pipeline.data.dataset import Dataset
from pipeline.evaluation.drives import read_drives
from tests.content import processor, run_hashes
from tests.stages.tiny import HOUSE, RUNS, TINY, dvc, linked, plan, reproduced

HELD = HOUSE / "tests" / "held" / "tiny.json"
OF_THE_REFERENCE = ("D_0", "D_safe", "D_held", "new_supervised_1")

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
    before = len(Dataset.open(house / "datasets" / "D_0"))
    for step in ("safedagger_1", "safedagger_2"):
        raw = Dataset.open(house / "datasets" / f"rollout_{step}")
        selected = Dataset.open(house / "datasets" / f"new_{step}")
        after = len(Dataset.open(house / "datasets" / f"D_{step}"))
        queries = int(raw.column("queried").sum())
        assert queries == len(selected) == after - before
        assert ledger_of(house, step)["queries"] == queries
        before = after


def test_a_part_of_d_safe_costs_its_part(house: Path) -> None:
    """And its frames are some of those that all others have."""
    whole, part = (Dataset.open(house / "datasets" / name) for name in ("D_safe", "D_safe_partly"))
    assert ledger_of(house, "safe")["queries"] == len(whole) == 40
    assert ledger_of(house, "safe_partly")["queries"] == len(part) == 30
    assert {*map(bytes, part.column("vehicle_state"))} < {
        *map(bytes, whole.column("vehicle_state"))
    }


@pytest.mark.parametrize(
    ("step", "queries", "added", "takeover"), [("dagger_1", 30, 12, 0), ("supervised_1", 20, 20, 1)]
)
def test_whoever_drives_all_that_is_collected_is_paid_for_and_dagger_trains_on_a_sample(
    house: Path, step: str, queries: int, added: int, takeover: float
) -> None:
    ledger = ledger_of(house, step)
    assert ledger["queries"] == ledger["frames_driven"] == queries
    assert (ledger["frames_selected"], ledger["takeover"]) == (added, takeover)


def test_all_strategies_are_evaluated(house: Path) -> None:
    driven = {"dagger_1": {"naive", "safe", "optimal"}, "ahead_0": {"safe"}}
    driven["scratch_2"] = {"naive", "safe"}
    for step, strategies in driven.items():
        drives = read_drives(house / f"cards/metrics/seed_0/drives_{step}.csv")
        assert set(drives.strategy) == strategies
        shown = strategies - {"optimal"}
        assert set(metric(house, f"driving_{step}")) == {"rows"} | shown


def test_every_primary_is_counted_on_alone(house: Path) -> None:
    """On more tracks at the end of a loop than between, in both conditions."""
    metrics = house / "cards" / "metrics" / "seed_0"
    drives = {path.stem: read_drives(path) for path in metrics.glob("reliability_*.csv")}
    ends = ("0", "safedagger_2", "dagger_1", "supervised_1", "ahead_1", "more_1")
    ends += ("audited_0", "audited_1", "partly_1")
    assert {name: len(table) for name, table in drives.items()} == {
        "reliability_safedagger_1": 2,
        **{f"reliability_{step}": 4 for step in ends},
    }
    assert all((table.strategy == "naive").all() for table in drives.values())


def test_the_ends_of_the_loops_are_driven_in_a_crowd(house: Path) -> None:
    """Before and after each, and in no other condition."""
    metrics = house / "cards" / "metrics" / "seed_0"
    drives = {path.stem: read_drives(path) for path in metrics.glob("crowd_*.csv")}
    ends = {path.stem for path in metrics.glob("reliability_*.csv")} - {"reliability_safedagger_1"}
    assert set(drives) == {name.replace("reliability", "crowd") for name in ends}
    for table in drives.values():
        (drive,) = table.to_dict("records")
        assert (drive["strategy"], drive["condition"], drive["traffic"]) == ("naive", "traffic", 4)


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
    dvc(house, f"plots show --out {house}/plots")
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
        planned = dvc(house, "repro --dry")
    finally:
        for name, text in before.items():
            (house / name).write_text(text)
    lines = [line for line in planned.splitlines() if line.startswith("Running stage")]
    stages = {line.split("'")[1] for line in lines}
    assert {"train-primary@safedagger_2", "train-primary-from-scratch@scratch_2"} <= stages
    steps = {name.split("@")[-1] for name in stages}
    assert steps <= {"safedagger_2", "scratch_2", "runs", "cards", "report"}


def test_without_a_run_that_needs_a_safety_policy_there_is_a_pipeline(tmp_path: Path) -> None:
    linked(tmp_path, TINY | {"runs": {"mine": RUNS["dagger"]}})
    dvc(tmp_path, "init --no-scm")
    stages = dvc(tmp_path, "stage list --name-only").split()
    assert "rollout-dagger@mine_1" in stages and "train-safety@mine_1" in stages
    assert not [name for name in stages if name.startswith(("rollout@", "select@", "contact"))]


GOOD = TINY | {
    "runs": {"safedagger": RUNS["safedagger"] | {"queries": [12], "from_scratch": []}},
    "train-safety": TINY["train-safety"] | {"cut": 0},
}


def test_a_rollout_in_which_nothing_was_unsafe_does_not_stop_the_loop(tmp_path: Path) -> None:
    """With a cut of 0 nothing is: D_1 is D_0, no query was paid, and all that follows runs."""
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
