"""Where a run falls short: by seed, strategy, condition and track, with how the drives ended."""

from dataclasses import replace

from pipeline.evaluation.experiment import Step
from pipeline.evaluation.outcomes import Outcome
from pipeline.report.shortfalls import falls_short
from pipeline.rollout.strategies import Strategy
from tests.evaluation.made_up import FULL, experiment


def steps(*changes: tuple[int, str, int, int, dict]) -> list[Step]:
    """Iteration 1 of two seeds, perfect but for the changes: seed, track, traffic, start, what."""

    def change(seed: int, drive: Outcome) -> Outcome:
        for number, track, traffic, start, what in changes:
            place = (seed, drive.track, drive.traffic > 0, drive.start, drive.strategy)
            if place == (number, track, traffic > 0, start, Strategy.NAIVE):
                return replace(drive, **what)
        return drive

    found = experiment({"safedagger": [FULL, FULL]}, seeds=2, starts=2).of("safedagger", 1)
    return [
        replace(step, drives=[change(step.seed, drive) for drive in step.drives]) for step in found
    ]


def test_nowhere() -> None:
    assert falls_short(steps()) == (
        "In the drives after iteration 1: in no case. There are 3 laps without damage in each of 24 cases of seed, "
        "driving strategy, traffic and track."
    )


def test_every_case_is_listed_with_how_its_drives_ended() -> None:
    text = falls_short(
        steps(
            (1, "yew", 0, 0, {"laps": 1.0, "off_road": True}),
            (0, "spruce", 1, 0, {"laps": 0.5, "off_road": False}),
            (0, "spruce", 1, 1, {"damage": 7.0}),
        )
    )
    assert text.startswith("In the drives after iteration 1: in 2 of 24 cases of seed,")
    assert "1 ended by leaving the road, 1 stopped short on it" in text
    assert "and 1 hit another car." in text
    assert text.splitlines()[-2:] == [
        "| 0 | naive, with traffic, spruce | 1.75 | 2 | 0 of 2 | 1 of 2 | 1 of 2 |",
        "| 1 | naive, without traffic, yew | 2.00 | 0 | 1 of 2 | 0 of 2 | 0 of 2 |",
    ]


def test_damage_alone_falls_short() -> None:
    text = falls_short(steps((0, "willow", 1, 0, {"damage": 3.0})))
    assert "| 0 | naive, with traffic, willow | 3.00 | 0.5 | 0 of 2 | 0 of 2 | 1 of 2 |" in text
