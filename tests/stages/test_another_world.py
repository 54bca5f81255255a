"""Algorithm 1 in a world of one file, tests/stages/pendulum.py, by the commands that the car has."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_all
from pipeline.data.schema import Asked
from pipeline.policies.inference import propose
from pipeline.policies.loading import load_primary
from tests.command import run

TASK = "--task tests.stages.pendulum:Pendulum --length 1.5 --seed 0"
FIT = (
    "--optimizer adamw --learning-rate 0.003 --weight-decay 0 --batch 8 --samples 400 "
    "--validation 0 --patience 1 --seed 0 --threads 1"
)
CONV = f"--policy conv --channels 4 --hidden 16 {FIT}"
SAFETY = (
    "--tau 0.01 --measure mean-square --horizon 0 --horizon-mode last --cut 0.5 --balance 1 "
    f"--held-out 0.25 --hidden 8 {FIT}"
)
DRIVEN = f"{TASK} --workers 1"
HELPED = DRIVEN.replace("Pendulum", "Helped")


def collect(name: str, episodes: int) -> str:
    return f"collect {name} {DRIVEN} --purpose {name} --iteration 0 --episodes {episodes}"


LOOP = (
    collect("D_0", 4),
    collect("D_safe", 8),
    f"train-primary D_0 primary_0 {CONV}",
    f"train-safety primary_0 D_safe D_0 safety_0 {SAFETY} --metrics s.json",
    f"rollout primary_0 safety_0 rollout_1 {DRIVEN} --iteration 1 --queries 20 --frames 60 "
    "--cut 0.9 --metrics rollout_1.json",
    "select rollout_1 new_1",
    "merge D_0 new_1 D_1",
    "ledger rollout_1 D_1 --metrics ledger_1.json",
    f"train-primary D_1 primary_1 --initial primary_0 {CONV}",
    f"train-safety primary_1 D_safe D_1 safety_1 {SAFETY} --metrics t.json",
    f"rollout-dagger primary_1 dagger_2 {DRIVEN} --iteration 2 --beta 0.5 --frames 30",
    "sample dagger_2 new_dagger_2 --frames 10 --seed 0",
    f"evaluate primary_1 {DRIVEN} --strategies naive --starts 1 --drives drives_1.csv "
    "--metrics driving_1.json",
    "errors primary_0 D_0 D_safe --tau 0.01 --measure mean-square --share 0.7 "
    "--figure errors.png --metrics errors.json",
    "inspect rollout_1 --save rollout_1.rrd",
    "compare rollout_1 D_0 --save compared_1.rrd",
    "contact-sheet rollout_1 sheet_1.png --frames 3",
    f"rollout primary_1 safety_1 rollout_2 {DRIVEN} --iteration 2 --queries 40 --audit 1 "
    "--metrics rollout_2.json",
    "select rollout_2 audits_2 --because audit",
    f"train-safety primary_1 D_safe D_1 safety_2 {SAFETY} --audits audits_2 --audits new_dagger_2",
)


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all of LOOP has run."""
    root = tmp_path_factory.mktemp("world")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        for command in LOOP:
            assert run(command) == 0, command
    return root


def test_what_is_collected_is_the_tasks(house: Path) -> None:
    d_0 = Dataset.open(house / "D_0")
    assert (len(d_0.lengths), d_0.fps, d_0.info["robot_type"]) == (4, 20, "pendulum")
    assert d_0.tasks[:2] == ["swing up a pendulum of 1.5 m", "hold up a pendulum of 1.5 m"]
    assert d_0.column("queried").all()
    state = d_0.columns(["observation.state"])["observation.state"]
    assert state.shape == (len(d_0), 3) and np.isfinite(state).all()
    assert d_0.lineage.own.arguments["length"] == 1.5
    assert d_0.drives.ended.tolist() == ["out of time"] * 4
    assert set(d_0.drives.upright) <= {0.0, 1.0}


def test_what_was_asked_is_what_was_selected_merged_and_counted(house: Path) -> None:
    before, driven, new, after = (
        Dataset.open(house / name) for name in ("D_0", "rollout_1", "new_1", "D_1")
    )
    queries = int(driven.column("queried").sum())
    assert 0 < queries == len(new) == len(after) - len(before)
    (ledger,) = json.loads((house / "ledger_1.json").read_text())["rows"]
    assert (ledger["queries"], ledger["frames_driven"]) == (queries, len(driven))
    hanging = int((driven.drives.upright == 0).sum())
    assert ledger["failures"] == ledger["failures.hangs"] == hanging > 0
    deviation = driven.column("deviation")
    actions = driven.columns(["action", "primary_action"])
    apart = (actions["action"] - actions["primary_action"])[:, 0] ** 2
    asked = driven.column("queried")
    np.testing.assert_allclose(deviation[asked], apart[asked], rtol=1e-5)
    assert np.isnan(deviation[~asked]).all()


def test_audits_are_queries_and_tell_what_looking_up_tells(house: Path) -> None:
    driven = Dataset.open(house / "rollout_2")
    assert driven.column("queried").all() and len(driven) == 40
    assert set(driven.column("asked_because")[~driven.column("intervention")]) == {Asked.AUDIT}
    (found,) = json.loads((house / "rollout_2.json").read_text())["rows"]
    assert found["audits"] == (~driven.column("intervention")).sum() > 0
    assert found["recall"] == found["estimated_recall"] is not None
    (unaudited,) = json.loads((house / "rollout_1.json").read_text())["rows"]
    assert "audits" not in unaudited


@pytest.mark.parametrize(("audit", "measured"), [(0, 0), (0.5, 0), (1, 60)])
def test_of_what_the_safety_policy_chose_to_ask_about_nothing_is_measured(
    house: Path, tmp_path: Path, audit: float, measured: int
) -> None:
    """Where nobody can be looked up, all frames that are known are those that it called unsafe."""
    asked = f"rollout {house}/primary_0 {house}/safety_0 {tmp_path}/asked {HELPED} --frames 60"
    metrics = tmp_path / "asked.json"
    assert run(f"{asked} --queries 60 --audit {audit} --metrics {metrics}") == 0
    (found,) = json.loads(metrics.read_text())["rows"]
    assert found["frames"] == measured
    for name in ("share_unsafe", "share_predicted_unsafe", "auroc", "calibration_error"):
        assert (found[name] is None) == (measured == 0)
    assert ("estimated_recall" in found) == (audit > 0)


def test_a_safety_policy_learns_from_audits_of_other_primaries_too(house: Path) -> None:
    """What was seen where another primary drove, each of them judged anew."""
    without, with_ = (json.loads((house / f"safety_{n}/safedagger.json").read_text()) for n in "12")
    ours = [Dataset.open(house / name).lineage.sha256 for name in ("audits_2", "new_dagger_2")]
    parents, more = (each["made"][each["sha256"]]["parents"] for each in (without, with_))
    assert more == parents + ours
    told, again = (each["made"][each["sha256"]]["arguments"] for each in (without, with_))
    assert told == again
    assert without["sha256"] != with_["sha256"]


def test_the_safety_policy_was_judged_by_the_measure_that_was_named(house: Path) -> None:
    config = json.loads((house / "safety_0" / "config.json").read_text())
    assert config["measure"] == "mean-square"
    labels = Dataset.open(house / "rollout_1").lineage.own.arguments["labels"]
    assert (labels["measure"], labels["tau"]) == ("mean-square", 0.01)


def test_where_all_is_safe_nothing_is_ranked(
    house: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    judged, out = f"judge {house}/primary_0 {house}/safety_0 {house}/rollout_1", tmp_path / "m.json"
    assert run(f"{judged} --tau 99 --known 0.05 --metrics {out}") == 0
    assert "rollout_1, known to within 0.05: -\n" in capsys.readouterr().out
    assert json.loads(out.read_text())["bounds"][0]["auroc"] is None


def test_of_a_training_that_fails_no_curve_is_left(
    house: Path, refused: Callable[..., str]
) -> None:
    """Here in a later epoch: the rate has to rise first."""
    wild = CONV.replace("0.003", "3e38").replace("--samples 400", "--samples 4000")
    assert "expected a lower one" in refused(f"train-primary D_0 x {wild} --curve x.csv", house)


def test_a_primary_is_evaluated_alone(house: Path) -> None:
    drives = (house / "drives_1.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in drives] == ["scenario", "swing up", "hold up"]
    measured = json.loads((house / "driving_1.json").read_text())
    assert set(measured["naive"]) == {"deviation"}
    assert [each["condition"] for each in measured["rows"]] == ["as_is"]


def test_its_errors_are_by_the_measure_that_was_named(house: Path) -> None:
    held_out = json.loads((house / "errors.json").read_text())["held_out"]
    d_safe = Dataset.open(house / "D_safe")
    assert held_out["frames"] == len(d_safe)
    network = load_primary(house / "primary_0")
    proposed, _ = propose(network, read_all(d_safe, network.seen))
    apart = proposed[:, 0] - d_safe.column("action")
    assert held_out["mean"] == pytest.approx(np.square(apart).mean(), rel=1e-3)


def test_the_second_primary_began_with_the_first(house: Path) -> None:
    weights = [(house / f"primary_{n}" / "model.safetensors").read_bytes() for n in (0, 1)]
    assert weights[0] != weights[1]


@pytest.mark.parametrize(
    ("typed", "named"),
    [
        (f"train-primary D_0 x {FIT} --policy nothing", "policy 'nothing': expected"),
        (f"train-primary D_0 x {FIT}", "(--policy driving; there are driving, conv)"),
        (
            f"train-safety primary_0 D_safe D_0 x {SAFETY} --measure steering",
            "expected the same (frames, 2)",
        ),
        (
            f"train-safety primary_1 D_safe D_1 x {SAFETY} --measure nothing",
            "measure 'nothing': expected one of mean-square",
        ),
        (
            f"train-safety primary_1 D_safe D_1 x {SAFETY} --audits new_1",
            "new_1: 20 of its frames are in D_1 too, expected none",
        ),
        (
            f"collect x {DRIVEN} --purpose D_0 --iteration 1 --episodes 1",
            "iteration is 1 of 'D_0', expected at most 0",
        ),
        (
            f"evaluate primary_1 safety_1 {HELPED} --strategies optimal --starts 1 --drives x.csv "
            "--metrics x.json",
            "optimal looks up the reference, which cannot be in this task, expected another rule",
        ),
        ("split D_0 x x --share 0.5", "x: given twice, expected a path for each output"),
        ("split D_0 x y --share 0.1", "share is 0.1 of the 4 episodes of D_0"),
        (
            "rollout primary_0 safety_0 x --tracks alder --traffic 0 --seconds 1 --workers 1",
            "task driving: column 'observation.image' is missing, expected uint8 [32, 32, 3] by the",
        ),
        (
            f"rollout-dagger primary_1 x {DRIVEN} --beta 0 --frames 9 --iteration 2 --hold 5",
            "hold is 5, expected at most 1: the chunk of this primary",
        ),
        ("compare rollout_1 D_0 --drive 4", "no drive 4 of a task that is in both"),
        (
            "contact-sheet rollout_1 x.png --frames 1 --camera observation.images.wrist",
            "rollout_1: has no camera 'observation.images.wrist', expected one of observation.image",
        ),
        ("contact-sheet D_0 x.png --frames 1", "0 frames have a safe probability, expected at"),
    ],
)
def test_what_does_not_fit_is_one_line_and_leaves_nothing(
    typed: str, named: str, house: Path, refused: Callable[..., str]
) -> None:
    assert named in refused(typed, house)
