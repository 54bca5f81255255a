"""What README and docs tell their readers to type: each command of ours is run by a test."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from joblib.externals.loky import get_reusable_executor

from pipeline.data.dataset import Dataset
from pipeline.evaluation.drives import read_drives
from pipeline.policies.loading import weights_sha256
from stages.__main__ import STAGES
from tests.command import typed
from tests.foreign import robot

ROOT = Path(__file__).parent.parent
PROGRAMS = ("safedagger", "lerobot-train")
SHOWS = {"inspect", "compare", "compare-policies", "watch"}
# what has more than one iteration, or another first one
OF_A_RUN = SHOWS | {"plan", "runs", "report", "results", "errors", "split"}


def section(page: str, heading: str) -> str:
    """What stands under a heading of a page: "by-hand" of docs/by-hand.md, "" of the README."""
    text = (ROOT / (f"docs/{page}.md" if page else "README.md")).read_text()
    return text.split(f"## {heading}\n")[1].split("\n## ")[0]


def commands(page: str, heading: str, programs: tuple[str, ...] = PROGRAMS) -> list[list[str]]:
    """The calls of some programs in the indented blocks under a heading, without their comments."""
    lines = section(page, heading).splitlines()
    code = "\n".join(line[4:] for line in lines if line.startswith("    "))
    calls = [shlex.split(line, comments=True) for line in code.replace("\\\n", " ").splitlines()]
    return [call for call in calls if call and call[0] in programs]


def python(page: str, heading: str) -> list[str]:
    """The blocks of Python under a heading."""
    return re.findall(r"```python\n(.*?)```", section(page, heading), re.DOTALL)


BY_HAND = ("by-hand", "One iteration")
LEROBOT = ("use-your-own", "Our primaries, trained by LeRobot")
TASK, REFERENCE, DATASET = (
    ("use-your-own", heading) for heading in ("A task in one file", "A reference", "A dataset")
)
LOOKING = [
    ("looking", heading) for heading in ("A dataset", "Two of them", "A drive, while it is driven")
]
ARM = ("by-hand", "The same with a robot arm")  # in tests/tasks/test_metaworld_loop.py
ACT = ("use-your-own", "A policy that LeRobot trains")  # there, too
SHAPE = ("extending", "A world")  # a command whose module is the reader's
PIPELINE = ("pipeline", "One iteration")
AUDITS = [
    ("audits", heading)
    for heading in ("What a safety policy misses", "Learning from audits", "Without D_safe")
]
CALM = ("audits", "Calmer handovers")
CONTEXT = ("datasets", "Context")


def test_every_command_of_the_pages_is_run_here() -> None:
    run = {BY_HAND, LEROBOT, TASK, REFERENCE, DATASET, *LOOKING, ARM, ACT, SHAPE, PIPELINE, CONTEXT}
    run |= {*AUDITS, CALM}
    found = set()
    for path in (ROOT / "README.md", *ROOT.glob("docs/*.md")):
        page = "" if path.name == "README.md" else path.stem
        for heading in re.findall(r"^## (.*)$", path.read_text(), re.MULTILINE):
            if commands(page, heading):
                found.add((page, heading))
    assert found == run


@pytest.fixture(scope="module")
def by_hand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where one iteration was typed as printed."""
    root = tmp_path_factory.mktemp("by_hand")
    (root / "examples").symlink_to(ROOT / "examples")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        for command in commands(*BY_HAND):
            typed(*command)
    return root


def test_one_iteration_by_hand(by_hand: Path) -> None:
    of_an_iteration = {*STAGES} - OF_A_RUN
    assert {command[1] for command in commands(*BY_HAND)} == of_an_iteration
    for name in ("new_1", "new_dagger_1"):
        assert len(Dataset.open(by_hand / "mine" / name)) == 50


def test_a_rule_of_ones_own_drives_as_the_page_shows(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(by_hand)
    exec("\n".join(python("extending", "A rule")), {"__name__": "page"})
    told = [line.split() for line in capsys.readouterr().out.splitlines()]
    queries, frames = (sum(int(line[n]) for line in told) for n in (0, 3))
    assert (queries, frames) == (50, 100)


def test_audits_are_learned_from_as_the_page_shows(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the reference that is calm keeps driving for a second, ten frames."""
    monkeypatch.chdir(by_hand)
    for part in (*AUDITS, CALM):
        for command in commands(*part):
            typed(*command)
    driven, new, audits = (
        Dataset.open(Path("mine") / name) for name in ("audited_1", "new_audited_1", "audits_1")
    )
    assert len(new) + len(audits) == driven.column("queried").sum() == 60
    assert len(audits) > 0 and not audits.column("intervention").any()
    drives = read_drives(Path("mine/calm.csv"))
    assert (drives.takeover_frames >= 10 * (drives.takeovers - 1)).all()  # it may end in one


@pytest.mark.parametrize(
    "command", [call for part in LOOKING for call in commands(*part)], ids=" ".join
)
def test_what_is_looked_at_can_be_saved(
    command: list[str], by_hand: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In place of a window or a page, and of what the page says it is saved as."""
    monkeypatch.chdir(by_hand)
    shown = [word for word in command if word not in ("--web", "--port", "9090")]
    if command[1] in SHOWS:
        shown = [*shown, "--save", str(tmp_path / "shown.rrd")]
    typed(*shown)


def test_lerobots_loader_opens_a_dataset_as_the_page_shows(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(by_hand)
    code = [line[4:] for line in section(*LOOKING[0]).splitlines() if line.startswith("    ")]
    known: dict[str, list] = {}
    exec("\n".join(line for line in code if line.split()[0] in ("from", "dataset")), known)
    assert len(known["dataset"]) > 0


def test_context_is_masked_as_the_page_shows(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is left of a chunk is what the reference did, frame by frame."""
    monkeypatch.chdir(by_hand)
    (command,) = commands(*CONTEXT)
    typed(*command)
    (code,) = python(*CONTEXT)
    known: dict = {}
    exec(code, known)
    rows, batch = known["dataset"].hf_dataset.with_format(None), known["batch"]
    for n, index in enumerate(batch["index"].tolist()):
        end = known["dataset"].meta.episodes[int(batch["episode_index"][n])]["dataset_to_index"]
        labels = rows[index : min(index + 16, end)]["queried"]
        assert (~batch["action_is_pad"][n]).tolist() == [*labels, *[False] * (16 - len(labels))]


def test_the_demo_films_and_records_a_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As make calls it, but for the rest of the lap."""
    make = ["make", "--dry-run", "--old-file=.venv/.ready", "demo"]
    recipe = subprocess.run(make, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(ROOT / "examples")
    # Beneath another make, as in `make test`, more is printed than the recipe.
    for line in recipe.splitlines():
        if line.startswith("safedagger "):
            typed(*shlex.split(line), "--laps", "0.1")
    assert {path.name for path in tmp_path.iterdir()} == {"examples", "demo.gif", "demo.rrd"}
    assert capsys.readouterr().out.count("ended: laps done") == 3


def test_a_task_and_a_reference_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    get_reusable_executor().shutdown()  # workers of an earlier test look for modules where it was
    ((_, source, place),) = commands(*TASK, ("cp",))
    shutil.copy(ROOT / source, place)
    (code,) = python(*REFERENCE)
    Path("my_reference.py").write_text(code)
    for command in (*commands(*TASK), *commands(*REFERENCE)):
        typed(*command)
    assert len(Dataset.open(Path("own/new_1"))) > 0
    hard, gentle = (
        abs(Dataset.open(Path(f"own/{name}")).column("action")).max() for name in ("D_0", "gentle")
    )
    assert gentle == np.float32(0.1) < hard


def test_a_dataset_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    robot(Path("theirs"))
    for command in commands(*DATASET):
        typed(*command)
    demos, corrected = (Dataset.open(Path("theirs") / name) for name in ("demos", "D_1"))
    assert len(corrected) == len(demos) + 4
    assert corrected.column("queried").all()


def test_the_car_is_made_by_gymnasium() -> None:
    known: dict = {}
    (code,) = python("use-your-own", "The car, for a learner of yours")
    exec(code, known)
    assert known["env"].observation_space.contains(known["observation"])
    known["env"].close()


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What LeRobot's commands look for, as it is installed; built from a copy, as setuptools leaves
    files where it builds."""
    shutil.copytree(ROOT / "plugin", tmp_path / "plugin")
    pip = "-m pip install --no-index --no-build-isolation --no-deps --target"
    command = [sys.executable, *pip.split(), tmp_path / "site", tmp_path / "plugin"]
    subprocess.run(command, check=True)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(ROOT), str(tmp_path / "site"))))


@pytest.mark.usefixtures("plugin")
def test_our_primaries_are_trained_by_lerobots_own_command(
    by_hand: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By type and by path: what it has saved drives, and is not what it began with."""
    monkeypatch.chdir(by_hand)
    for command in commands(*LEROBOT):
        typed(*command)
    assert read_drives(Path("mine/by_lerobot.csv")).frames.min() > 0
    further = Path("mine/further_by_lerobot/checkpoints/last/pretrained_model")
    assert weights_sha256(further) != weights_sha256(Path("mine/primary_0"))


def test_what_is_read_of_the_pipeline_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing has run: its results in git, and what a stage depends on, as the page draws it."""
    monkeypatch.chdir(ROOT)
    (called,) = commands(*PIPELINE)
    typed(*called)
    drawn = ["dag", "--md", "train-safety@safedagger_1"]
    assert f"`dvc {' '.join(drawn)}`" in section(*PIPELINE)
    shown = subprocess.run(
        [sys.executable, "-m", "dvc", *drawn], check=True, capture_output=True, text=True
    ).stdout
    assert shown.strip() in section(*PIPELINE)
