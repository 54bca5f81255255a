import json
from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.driving.network import PrimaryNetwork
from pipeline.policies.network import SafetyNetwork
from pipeline.policies.safety import SafetyConfig, SafetyPolicy
from pipeline.rollout.judgement import Judgement, rule_of
from pipeline.rollout.rules.calm import Calm
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import DRIVING, Strategy


@pytest.mark.parametrize(("measure", "more"), [("steering", 0), ("steering-and-brake", 1)])
def test_it_goes_by_the_labels_and_the_cut_of_the_safety_policy(
    measure: str, more: int, tmp_path: Path
) -> None:
    network = SafetyNetwork(
        PrimaryNetwork(4).feature_size, 8, generator=torch.Generator().manual_seed(1)
    )
    config = SafetyConfig(
        features=network.in_features, hidden=8, tau=0.01, cut=0.4, measure=measure
    )
    SafetyPolicy(config, network).save_pretrained(tmp_path)
    assert Judgement.read(tmp_path) == Judgement(0.4, 0.01, measure)
    judgement = Judgement.read(tmp_path, 0.3)
    assert rule_of(Strategy.SAFE, judgement) == Calm(Safe(0.3), 0.3, 0)
    assert rule_of(Strategy.SAFE, judgement, resume=0.7, least=9) == Calm(Safe(0.3), 0.7, 9)
    with pytest.raises(ValueError, match=r"resume is 0.2, expected at least the cut, 0.3"):
        rule_of(Strategy.SAFE, judgement, resume=0.2)
    optimal = rule_of(Strategy.OPTIMAL, judgement)
    assert optimal.tau == 0.01
    actions = np.float32([[0.1, 0.0]]), np.float32([[0.3, 1.0]])
    expected = pytest.approx([0.04 + more])
    assert optimal.deviation(*actions) == expected == judgement.deviation(*actions)
    with pytest.raises(ValueError, match=r"config.json: No such file"):
        Judgement.read(tmp_path / "missing")
    config = json.loads((tmp_path / "config.json").read_text())
    del config["half_range"]
    (tmp_path / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"config.json: half_range is missing, expected"):
        Judgement.read(tmp_path)


def test_each_driving_strategy_has_its_rule() -> None:
    judgement = Judgement(0.5, 0.0025, "steering-and-brake")
    for strategy in (*DRIVING, Strategy.REFERENCE):
        assert rule_of(strategy, judgement).name == strategy
    with pytest.raises(ValueError, match="strategy is mixture"):
        rule_of(Strategy.MIXTURE, judgement)


def test_only_what_goes_by_a_safety_policy_needs_one() -> None:
    assert rule_of(Strategy.NAIVE, None) == Naive()
    assert rule_of(Strategy.REFERENCE, None) == Reference()
    for strategy in (Strategy.SAFE, Strategy.OPTIMAL):
        with pytest.raises(ValueError, match=f"strategy is {strategy}, which needs a safety"):
            rule_of(strategy, None)
