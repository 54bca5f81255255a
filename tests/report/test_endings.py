"""How the drives ended that did not do all laps, in counts."""

from dataclasses import replace
from typing import Any

from pipeline.evaluation.experiment import Experiment, Step
from pipeline.report.endings import endings
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import FULL, changed, experiment, with_optimal

LEFT = {"laps": 1.0, "off_road": True}
STOPPED = {"laps": 2.99, "off_road": False}


def ended(strategy: Strategy, traffic: bool, **changes: Any) -> Experiment:
    """Perfect drives of two seeds and iterations, but for one of DAgger's iteration 1, seed 1."""

    def change(step: Step) -> Step:
        if (step.seed, step.run, step.iteration) != (1, "dagger", 1):
            return step
        first = next(d for d in step.drives if (d.strategy, d.traffic > 0) == (strategy, traffic))
        drives = [replace(d, **changes) if d == first else d for d in step.drives]
        return replace(step, drives=drives)

    made_up = experiment({"dagger": [FULL, FULL], "safedagger": [FULL, FULL]}, seeds=2, starts=1)
    return changed(made_up, change)


def test_drives_that_left_the_road_and_that_stopped_on_it_are_told_apart() -> None:
    left, perfect = endings(ended(Strategy.NAIVE, True, **LEFT))
    assert left.splitlines() == [
        "| Run | Iteration | Left the road, naive | Stopped on the road, naive |",
        "| --- | ---: | ---: | ---: |",
        "| DAgger | 1 | 0 of 6 / 1 of 6 | 0 of 6 / 0 of 6 |",
    ]
    assert perfect == "All safe drives did 3 laps."
    stopped, _ = endings(ended(Strategy.NAIVE, False, **STOPPED))
    assert stopped.splitlines()[2:] == ["| DAgger | 1 | 0 of 6 / 0 of 6 | 1 of 6 / 0 of 6 |"]


def test_every_driving_strategy_has_its_table_or_its_sentence() -> None:
    perfect, safe = endings(ended(Strategy.SAFE, True, **STOPPED))
    assert perfect == "All naive drives did 3 laps."
    assert safe.startswith("| Run | Iteration | Left the road, safe |")
    driven = changed(ended(Strategy.SAFE, True, **LEFT), lambda step: with_optimal(step, laps=3.0))
    left, optimal = list(endings(driven))[1:]
    assert "| 0 of 6 / 1 of 6 |" in left
    assert optimal.startswith("| Run | Iteration | Left the road, optimal |")
    naive = changed(
        driven,
        lambda step: replace(step, drives=[d for d in step.drives if d.strategy == "naive"]),
    )
    assert list(endings(naive)) == ["All naive drives did 3 laps."]


def test_a_condition_that_nobody_met_has_no_counts() -> None:
    made_up = ended(Strategy.NAIVE, False, **LEFT)
    quiet = changed(
        made_up, lambda step: replace(step, drives=[d for d in step.drives if not d.traffic])
    )
    assert next(endings(quiet)).endswith("| 1 of 6 / - | 0 of 6 / - |")
