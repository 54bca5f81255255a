"""`make experiment`: a scale on a seed, in a house of its own beside the user's work."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
# The pipeline's shape in cheap commands. `train` waits while there is a file `hold` in the checkout.
PIPELINE = """
stages:
  collect:
    cmd: echo collect >> ran; mkdir -p datasets/D_0; echo ${seed} ${passes} > datasets/D_0/data
    deps: [pipeline, stages]
    outs: [datasets/D_0]
  train:
    cmd: echo train >> ran; while [ -e ../../hold ]; do sleep 0.1; done; cp -r datasets/D_0 models
    deps: [datasets/D_0]
    outs: [models]
  evaluate:
    cmd: mkdir -p cards/metrics/seed_${seed}; cp models/data cards/metrics/seed_${seed}/driving_0.json
    deps: [models]
    metrics:
      - cards/metrics/seed_${seed}/driving_0.json:
          cache: false
  errors:
    cmd: mkdir -p cards/errors; cp models/data cards/errors/seed_${seed}.png
    deps: [models]
    outs:
      - cards/errors/seed_${seed}.png:
          cache: false
  contact-sheet:
    cmd: mkdir -p cards/frames; cp models/data cards/frames/seed_${seed}.png
    deps: [models]
    outs:
      - cards/frames/seed_${seed}.png:
          cache: false
  report:
    cmd: cat cards/metrics/*/* > cards/report.md
    deps: [cards/metrics]
    outs:
      - cards/report.md:
          cache: false
"""
RUNS = """protocols: {long: {}}
runs:
  mine: {strategy: dagger, frames: [9], sample: [9], samples: [9], tau: [0], driven_by: naive,
    protocol: long, name: mine, words: mine, colour: black, marker: o}
"""
NEW = {"cards/errors/seed_1.png", "cards/frames/seed_1.png"}
CHANGED = {"cards/metrics/seed_1/driving_0.json", "cards/report.md"}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout with edited parameters, data, and what earlier runs have found out."""
    for name in ("pipeline", "stages"):
        (tmp_path / name).symlink_to(ROOT / name)
    for name in ("Makefile", ".dvcignore", ".dvc/config", "scales/run"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    files = {
        "dvc.yaml": PIPELINE,
        "params.yaml": "seed: 0\npasses: 3 # edited",
        "scales/tiny.yaml": f"# tiny\nseed: 0\npasses: 7\n{RUNS}",
        "datasets/D_0/data": "the user's",
        "models/data": "the user's",
        "cards/report.md": "old",
        "cards/metrics/seed_0/driving_0.json": "0 5\n",
        "cards/metrics/seed_1/driving_0.json": "old",
        "cards/metrics/seed_1/driving_other_1.json": "old",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "init", "--quiet", tmp_path], check=True)
    return tmp_path


def contents(checkout: Path) -> dict[str, bytes]:
    """Every file that is not DVC's, git's, or in an experiment's own house."""
    paths = [path for path in checkout.rglob("*") if path.is_file()]
    names = {str(path.relative_to(checkout)): path for path in paths}
    own = (".git/", ".dvc/", "dvc.lock", "experiments/")
    return {name: path.read_bytes() for name, path in names.items() if not name.startswith(own)}


def start(checkout: Path, scale: str = "tiny", seed: str = "1") -> subprocess.Popen[str]:
    """`make experiment`; -o: the environment is there, as .venv of another checkout."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    return subprocess.Popen(
        ["make", "-o", ".venv/.ready", "experiment", f"SCALE={scale}", f"SEED={seed}"],
        cwd=checkout,
        env=environment | {"PATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def complete(checkout: Path) -> None:
    process = start(checkout)
    out, err = process.communicate()
    assert process.returncode == 0, out + err


def refusal(checkout: Path, scale: str, seed: str) -> str:
    """The one line that make did not write itself."""
    process = start(checkout, scale, seed)
    err = process.communicate()[1]
    assert process.returncode == 2
    (line,) = [line for line in err.splitlines() if not line.startswith("make: ***")]
    return line


def ran(checkout: Path) -> list[str]:
    return (checkout / "experiments" / "tiny_1" / "ran").read_text().split()


def test_only_what_is_known_of_the_seed_is_changed(checkout: Path) -> None:
    before = contents(checkout)
    complete(checkout)
    after = contents(checkout)
    assert after.keys() - before.keys() == NEW
    assert before.keys() - after.keys() == {"cards/metrics/seed_1/driving_other_1.json"}
    assert {name for name in before.keys() & after if before[name] != after[name]} == CHANGED
    assert {after[name] for name in NEW} == {b"1 7\n"}
    assert after["cards/report.md"] == b"0 5\n1 7\n"
    house = checkout / "experiments" / "tiny_1"
    assert '"mine_1"' in (house / "loops.yaml").read_text()
    assert (house / "params.yaml").read_text() == f"# tiny\nseed: 1\npasses: 7\n{RUNS}"

    complete(checkout)
    assert ran(checkout) == ["collect", "train"]
    assert contents(checkout) == after


def test_a_run_that_was_killed_goes_on_where_it_was(checkout: Path) -> None:
    half_built = checkout / "experiments" / "tiny_1.new"
    half_built.mkdir(parents=True)
    (half_built / "params.yaml").write_text("se")
    (checkout / "hold").touch()
    before = contents(checkout)
    process = start(checkout)
    wait_until_it_trains(checkout, process)
    assert "experiments/tiny_1 is running already" in refusal(checkout, "tiny", "1")
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert contents(checkout) == before

    (checkout / "hold").unlink()
    complete(checkout)
    assert ran(checkout) == ["collect", "train", "train"]
    assert contents(checkout)["cards/report.md"] == b"0 5\n1 7\n"
    assert contents(checkout)["params.yaml"] == before["params.yaml"]


def wait_until_it_trains(checkout: Path, process: subprocess.Popen[str]) -> None:
    log = checkout / "experiments" / "tiny_1" / "ran"
    while not log.exists() or "train" not in log.read_text():
        assert process.poll() is None, process.communicate()
        time.sleep(0.1)


@pytest.mark.parametrize(
    ("scale", "seed"),
    [("typo", "1"), ("", "1"), ("../params", "1"), ("tiny", "x"), ("tiny", "-1"), ("tiny", "01")],
)
def test_what_cannot_be_run_changes_nothing(checkout: Path, scale: str, seed: str) -> None:
    before = contents(checkout)
    line = refusal(checkout, scale, seed)
    assert f"SCALE={scale} SEED={seed}" in line and "one of: tiny;" in line
    assert contents(checkout) == before
    assert not (checkout / "experiments").exists()


def test_an_edited_experiment_is_not_overwritten(checkout: Path) -> None:
    params = checkout / "experiments" / "tiny_1" / "params.yaml"
    params.parent.mkdir(parents=True)
    params.write_text("# tiny\nseed: 1\npasses: 8\n")
    before = contents(checkout)
    assert "experiments/tiny_1/params.yaml is not scales/tiny.yaml" in refusal(
        checkout, "tiny", "1"
    )
    assert params.read_text() == "# tiny\nseed: 1\npasses: 8\n"
    assert contents(checkout) == before


@pytest.mark.parametrize("seed", [[], ["7"]])
def test_a_study_without_policies_is_one_line_and_changes_nothing(
    checkout: Path, seed: list[str]
) -> None:
    shutil.copy(ROOT / "scales/study", checkout / "scales/study")
    before = contents(checkout)
    done = subprocess.run([checkout / "scales/study", *seed], capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "has no models, expected those of make experiment SCALE=curves" in line
    assert contents(checkout) == before
    assert not (checkout / "experiments").exists() and not (checkout / "cards/study").exists()


def test_what_is_per_seed_is_the_same_in_the_real_pipeline() -> None:
    def per_seed(pipeline: str) -> set[str]:
        return set(re.findall(r"cards/\w+/seed_\$\{seed\}(?:\.png)?", pipeline))

    assert per_seed((ROOT / "dvc.yaml").read_text()) == per_seed(PIPELINE)
