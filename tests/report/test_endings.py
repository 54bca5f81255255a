"""How the drives ended that did not do all laps, in counts."""

from typing import Any

from pipeline.evaluation.experiment import Experiment, Step
from pipeline.report.endings import endings
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import FULL, changed, experiment, only, redriven, with_optimal

LEFT = {"laps": 1.0, "off_road": 1.0}
STOPPED = {"laps": 2.99, "off_road": 0.0}


def ended(strategy: Strategy, where: str, **changes: Any) -> Experiment:
    """Perfect drives of two seeds and iterations, but for one of DAgger's iteration 1, seed 1."""

    def change(step: Step) -> Step:
        if (step.seed, step.run, step.iteration) != (1, "dagger", 1):
            return step
        return redriven(step, changes, strategy=strategy, condition=where, scenario="yew")

    made_up = experiment({"dagger": [FULL, FULL], "safedagger": [FULL, FULL]}, seeds=2, starts=1)
    return changed(made_up, change)


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
    driven = changed(
        ended(Strategy.SAFE, "traffic", **LEFT), lambda step: with_optimal(step, laps=3.0)
    )
    left, optimal = list(endings(driven))[1:]
    assert "| 0 of 6 / 1 of 6 |" in left
    assert optimal.startswith("| Run | Iteration | Left the road, optimal |")
    naive = changed(driven, lambda step: only(step, strategy="naive"))
    assert list(endings(naive)) == ["All naive drives did 3 laps."]


def test_a_condition_that_nobody_met_has_no_counts() -> None:
    made_up = ended(Strategy.NAIVE, "no_traffic", **LEFT)
    quiet = changed(made_up, lambda step: only(step, condition="no_traffic"))
    assert next(endings(quiet)).endswith("| 1 of 6 / - | 0 of 6 / - |")
