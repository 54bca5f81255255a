"""How the drives ended that did not do all laps, in counts."""

from typing import Any

from pipeline.evaluation.experiment import Experiment
from pipeline.report.tables import endings
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import FULL, experiment, redriven, undriven, with_optimal

LEFT = {"laps": 1.0, "off_road": 1.0}
STOPPED = {"laps": 2.99, "off_road": 0.0}


def ended(strategy: Strategy, where: str, **changes: Any) -> Experiment:
    """Perfect drives of two seeds and iterations, but for one of DAgger's iteration 1, seed 1."""

    made_up = experiment({"dagger": [FULL, FULL], "safedagger": [FULL, FULL]}, seeds=2, starts=1)
    here = {"seed": 1, "run": "dagger", "iteration": 1, "scenario": "yew"}
    return redriven(made_up, changes, **here, strategy=strategy, condition=where)


def test_drives_that_left_the_road_and_that_stopped_on_it_are_told_apart() -> None:
    left, perfect = endings(ended(Strategy.NAIVE, "traffic", **LEFT))
    assert left.splitlines() == [
        "| Run | Iteration | Left the road, naive | Stopped on the road, naive |",
        "| --- | ---: | ---: | ---: |",
        "| DAgger | 1 | 0 of 6 / 1 of 6 | 0 of 6 / 0 of 6 |",
    ]
    assert perfect == "All safe drives did 3 laps."
    stopped, _ = endings(ended(Strategy.NAIVE, "no_traffic", **STOPPED))
    assert stopped.splitlines()[2:] == ["| DAgger | 1 | 0 of 6 / 0 of 6 | 1 of 6 / 0 of 6 |"]


def test_every_driving_strategy_has_its_table_or_its_sentence() -> None:
    perfect, safe = endings(ended(Strategy.SAFE, "traffic", **STOPPED))
    assert perfect == "All naive drives did 3 laps."
    assert safe.startswith("| Run | Iteration | Left the road, safe |")
    driven = with_optimal(ended(Strategy.SAFE, "traffic", **LEFT), laps=3.0)
    left, optimal = list(endings(driven))[1:]
    assert "| 0 of 6 / 1 of 6 |" in left
    assert optimal.startswith("| Run | Iteration | Left the road, optimal |")
    naive = undriven(driven, strategy=["safe", "optimal"])
    assert list(endings(naive)) == ["All naive drives did 3 laps."]


def test_a_condition_that_nobody_met_has_no_counts() -> None:
    made_up = ended(Strategy.NAIVE, "no_traffic", **LEFT)
    quiet = undriven(made_up, run="dagger", iteration=1, condition="traffic")
    assert next(endings(quiet)).endswith("| 1 of 6 / - | 0 of 6 / - |")
