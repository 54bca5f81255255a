import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.rollout.judgement import Judgement, rule_of
from pipeline.rollout.rules.calm import Calm
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.strategies import DRIVING, Strategy
from tests.drives import save_untrained


@pytest.mark.parametrize(("measure", "more"), [("steering", 0), ("steering-and-brake", 1)])
def test_it_goes_by_the_labels_and_the_cut_of_the_safety_policy(
    measure: str, more: int, tmp_path: Path
) -> None:
    safety = tmp_path / "safety"
    save_untrained(tmp_path / "primary", safety, tau=0.01, cut=0.4, measure=measure)
    assert Judgement.read(safety) == Judgement(0.4, 0.01, measure)
    judgement = Judgement.read(safety, 0.3)
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
    config = json.loads((safety / "config.json").read_text())
    del config["half_range"]
    (safety / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"config.json: half_range is missing, expected"):
        Judgement.read(safety)


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
