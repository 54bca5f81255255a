"""Algorithm 1 with a robot arm, by the commands that README and docs tell their readers to type."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.data.dataset import Dataset
from pipeline.policies.loading import policy_lineage
from tests.command import typed
from tests.test_readme import ACT, ARM, commands


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all of them have run."""
    root = tmp_path_factory.mktemp("world")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        for command in (*commands(*ARM), *commands(*ACT)):
            typed(*command)
    return root / "arm"


def test_it_is_driven_selected_merged_and_counted(arm: Path) -> None:
    before, driven, new, after = (
        Dataset.open(arm / name) for name in ("D_0", "rollout_1", "new_1", "D_1")
    )
    asked = driven.column("queried")
    assert 0 < asked.sum() == len(new) == len(after) - len(before)
    (ledger,) = json.loads((arm / "ledger_1.json").read_text())["rows"]
    assert (ledger["queries"], ledger["frames_trained"]) == (asked.sum(), len(after))
    actions = driven.columns(["action", "primary_action"])
    apart = actions["action"] - actions["primary_action"]
    np.testing.assert_allclose(
        driven.column("deviation")[asked], np.square(apart).mean(axis=1)[asked], rtol=1e-5
    )
    # some of what the primary does is unsafe to the safety policy, some is not
    safe = driven.column("safe_probability") >= 0.5
    assert 0 < safe.sum() < len(safe)
    np.testing.assert_array_equal(asked, ~safe)


def test_the_second_primary_comes_from_the_first_and_from_what_was_asked(arm: Path) -> None:
    first, second = (policy_lineage(arm / name) for name in ("primary_0", "primary_1"))
    d_1 = Dataset.open(arm / "D_1").lineage
    assert {each.sha256 for each in second.parents} == {first.sha256, d_1.sha256}


def test_it_is_evaluated_by_success(arm: Path) -> None:
    measured = json.loads((arm / "driving_0.json").read_text())
    drives = pd.read_csv(arm / "drives_0.csv")
    assert drives.groupby("strategy").size().to_dict() == {"naive": 3, "safe": 3}
    for strategy, driven in drives.groupby("strategy"):
        found = measured[strategy]
        assert found["success"] == pytest.approx(driven.success.mean(), rel=1e-5)
        takeover = driven.takeover_frames.sum() / driven.frames.sum()
        assert found.get("takeover", 0) == pytest.approx(takeover, rel=1e-5)
    assert set(drives.ended) <= {"success", "out of time"}
    assert ((drives.ended == "success") == (drives.success == 1)).all()


def test_act_trained_by_lerobot_is_driven_and_watched(arm: Path) -> None:
    driven = Dataset.open(arm / "rollout_act")
    columns = driven.columns(["primary_action", "safe_probability"])
    assert all(np.isfinite(values).all() for values in columns.values())
    assert np.ptp(columns["primary_action"], axis=0).max() > 0
    unsafe = columns["safe_probability"].ravel() < 0.5
    np.testing.assert_array_equal(driven.column("queried"), unsafe)
