"""Commands one after the other: what one wrote, the next reads, or refuses to."""

import re
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Asked
from pipeline.inspection.excerpts import whole_episodes
from pipeline.policies.loading import weights_sha256
from tests.command import run
from tests.episodes import random_episode, write

DRIVES = "--traffic 2 --action-repeat 3"
PRIMARY = "--channels 2 --batch 4 --samples 4 --threads 1"
SAFETY = "--hidden 4 --held-out 0.5 --batch 4 --samples 4 --threads 1"


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """To stand in: D_0 and D_safe."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    where = "drive on yew with 2 other cars"
    for name in ("D_0", "D_safe"):
        episodes = [
            random_episode(rng, 3, task=where, episode=n, reference_only=True) for n in (0, 1)
        ]
        write(Path(name), episodes, name)
    return tmp_path


def test_why_drives_ended_is_said_of_a_dataset_and_of_its_episodes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    typed = f"collect D_0 {DRIVES} --tracks alder --seconds 0.2 --episodes 2 --workers 1"
    assert run(typed) == 0
    assert capsys.readouterr().out == (
        "D_0: 2 episodes, 4 frames, 4 queries; ended: out of time 2\n"
    )
    titles = [excerpt.title for excerpt in whole_episodes(Dataset.open(Path("D_0")))]
    assert all(title.endswith("; ended: out of time") for title in titles)


def test_what_nobody_asked_is_selected_merged_and_counted(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A rollout in which nothing was unsafe: the primary has become good, and all goes on."""
    safe = random_episode(np.random.default_rng(0), 4, asked=[Asked.NOT] * 4)
    write(Path("rollout_1"), [safe], "rollout")
    for command, last in {
        "select rollout_1 new_1": "new_1: 0 episodes, 0 frames, 0 queries",
        "merge D_0 new_1 D_1": "D_1: 2 episodes, 6 frames, 6 queries",
        "ledger rollout_1 D_1 --metrics ledger.json": "ledger.json: 4 frames of 1 drives in 1 "
        "scenarios; 0 queries, 0 of them audits; 0 calls of the reference for 0 frames, 0 switches; "
        "0 frames selected, 6 trained on",
        "inspect D_1 --save D_1.rrd": "D_1.rrd: open it with `rerun D_1.rrd`",
    }.items():
        assert run(command) == 0
        said = capsys.readouterr().out.splitlines()
        assert said[-1] == last
        if command.startswith(("select", "merge")):
            assert "nothing to" in said[-2]
    assert run("inspect new_1 --save x.rrd") == 2
    error = capsys.readouterr().err
    assert error == "safedagger: new_1: has no frames, expected some to look at\n"


def test_training_is_refused_what_would_spoil_it(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No frame with a label; D_safe that was trained on; a safety policy of another primary."""
    unasked = random_episode(np.random.default_rng(1), 9, asked=[Asked.NOT] * 9)
    write(Path("rollout"), [unasked], "rollout")
    drive = f"{DRIVES} --tracks yew --strategy safe --seconds 0.2 --save drive.rrd"
    for command, problem in {
        f"train-primary D_0 one {PRIMARY}": None,
        f"train-primary D_0 other {PRIMARY} --seed 1 --curve curve.csv": None,
        f"train-primary D_0 bad {PRIMARY} --curve curve.csv": "curve.csv: exists already, .*",
        f"train-primary rollout bad {PRIMARY}": "rollout: of 9 frames none has a label of the "
        "reference, expected some to learn from",
        f"train-safety one D_0 D_0 bad {SAFETY}": "D_0: 6 of its frames are in D_0 too, "
        "expected none",
        f"train-safety one D_0 D_safe bad {SAFETY}": "D_0: one was trained on it, "
        r"expected a D_safe \(are the two swapped\?\)",
        f"train-safety one D_safe D_0 safe {SAFETY}": None,
        f"watch other safe {drive}": "safe: was trained to watch another primary than other",
    }.items():
        assert run(command) == (2 if problem else 0), command
        error = capsys.readouterr().err
        assert problem is None or re.fullmatch(f"safedagger: {problem}\n", error)
    assert re.fullmatch(r"epoch,samples,loss\n1,4,[0-9.]+\n", Path("curve.csv").read_text())
    assert not Path("bad").exists() and not Path("drive.rrd").exists()
    assert run(f"watch one safe {drive}") == 0


def test_context_changes_no_training(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same frames are shown, held out and foreseen: of both policies, the same weights."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    demonstrated = [random_episode(rng, 6, episode=n, reference_only=True) for n in (0, 1)]
    write(Path("D_safe"), demonstrated, "D_safe")
    drives = [random_episode(rng, 20, iteration=1, episode=n) for n in (0, 1)]
    write(Path("rollout"), drives, "rollout")
    trained = []
    for name, context in (("bare", ""), ("around", "--before 0.1 --after 0.2")):
        primary, safety = f"primary_{name}", f"safety_{name}"
        ahead = "--horizon 0.3 --tau 0.3 --validation 0.3"
        for command in (
            f"select rollout {name} {context}",
            f"train-primary {name} {primary} {PRIMARY} --validation 0.3",
            f"train-safety {primary} D_safe {name} {safety} {SAFETY} {ahead}",
        ):
            assert run(command) == 0
        trained.append([weights_sha256(Path(policy)) for policy in (primary, safety)])
    assert trained[0] == trained[1]


def test_the_cut_of_a_rollout_is_its_safety_policys_own(root: Path) -> None:
    """It is said once, where the policy is trained; a rollout may be told another, and keeps it.

    What deviates is the primary's, if nobody says; and without a place for metrics, none is written.
    """
    assert run(f"train-primary D_0 primary {PRIMARY}") == 0
    assert run(f"train-safety primary D_safe D_0 safety {SAFETY} --cut 1") == 0
    drives = f"{DRIVES} --tracks alder --seconds 1 --queries 99 --frames 10 --workers 1"
    for name, told, cut, drove in (("own", "", 1, 10), ("told", "--cut 0", 0, 0)):
        assert run(f"rollout primary safety {name} {drives} {told}") == 0
        driven = Dataset.open(Path(name))
        assert driven.lineage.own.arguments["cut"] == cut
        labels = driven.lineage.own.arguments["labels"]
        assert (labels["tau"], labels["measure"]) == (0.0025, "steering-and-brake")
        trained = driven.lineage.parents[1].own.arguments
        assert (trained["cut"], trained["measure"]) == (1, "steering-and-brake")
        assert [parent.own.purpose for parent in driven.lineage.parents] == ["primary", "safety"]
        assert int(driven.column("intervention").sum()) == drove
        assert run(f"select {name} new_{name}") == 0
        assert len(Dataset.open(Path(f"new_{name}"))) == drove
    assert not list(root.glob("*.json"))
