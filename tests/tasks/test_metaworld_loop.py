"""Algorithm 1 with a robot arm, by the commands that the README tells its readers to type."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from tests.tasks.conftest import Command
from tests.test_readme import commands


def test_it_is_collected_learned_driven_selected_merged_and_learned_again(
    safedagger: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    typed = commands("Another robot, another policy")
    for _, *arguments in typed:
        code, _, error = safedagger(*arguments)
        assert code == 0, (arguments, error)
    assert [command[1] for command in typed][-5:-2] == ["select", "merge", "ledger"]

    before, driven, new, after = (
        Dataset.open(Path("arm", name)) for name in ("D_0", "rollout_1", "new_1", "D_1")
    )
    asked = driven.column("queried")
    assert 0 < asked.sum() == len(new) == len(after) - len(before)
    ledger = json.loads(Path("arm/ledger_1.json").read_text())
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
