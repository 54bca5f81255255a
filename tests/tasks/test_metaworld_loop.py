"""Algorithm 1 with a robot arm, by the commands that the car has."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from tests.tasks.conftest import Command

ARM = "--task metaworld --tasks button-press-topdown-v3 --perturb 5 --steps 100 --seed 0"
FIT = (
    "--optimizer adamw --learning-rate 0.001 --weight-decay 0 --batch 32 --passes 1500"
    " --validation 0 --patience 1 --seed 0 --threads 1"
)
CONV = "--policy conv --channels 8 --channels 16 --hidden 32"
SAFETY = (
    "--tau 0.05 --measure mean-square --horizon 0 --horizon-mode last --cut 0.5 --balance 1"
    " --held-out 0.34 --hidden 8"
)
LOOP = f"""
collect D_0 {ARM} --purpose D_0 --iteration 0 --episodes 3 --workers 1
collect D_safe {ARM} --purpose D_safe --iteration 0 --episodes 3 --workers 1
train-primary D_0 primary_0 {CONV} {FIT}
train-safety primary_0 D_safe D_0 safety_0 {SAFETY} {FIT} --metrics safety_0.json
rollout primary_0 safety_0 rollout_1 {ARM} --iteration 1 --cut 0.5 --queries 30 --frames 120 \
    --workers 1 --metrics rollout_1.json
select rollout_1 new_1
merge D_0 new_1 D_1
ledger rollout_1 D_1 --metrics ledger_1.json
train-primary D_1 primary_1 --initial primary_0 {CONV} {FIT}
"""


def test_it_is_collected_learned_driven_selected_merged_and_learned_again(
    safedagger: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for line in LOOP.replace("\\\n", "").strip().splitlines():
        code, _, error = safedagger(*line.split())
        assert code == 0, f"{line}: {error}"

    before, driven, new, after = map(Dataset.open, map(Path, ("D_0", "rollout_1", "new_1", "D_1")))
    asked = driven.column("queried")
    assert 0 < asked.sum() == len(new) == len(after) - len(before)
    ledger = json.loads(Path("ledger_1.json").read_text())
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
