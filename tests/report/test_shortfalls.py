"""Where a run falls short: by seed, strategy, condition and track, with how the drives ended."""

from pipeline.report.shortfalls import falls_short
from tests.evaluation.made_up import FULL, experiment, redriven


def shown(*changes: tuple[int, str, int, int, dict]) -> str:
    """Iteration 1 of two seeds, perfect but for the changes: seed, track, traffic, start, what."""
    found = experiment({"safedagger": [FULL, FULL]}, seeds=2, starts=2)
    for seed, track, traffic, start, what in changes:
        where = ("no_traffic", "traffic")[traffic]
        here = {"seed": seed, "iteration": 1, "strategy": "naive", "condition": where}
        found = redriven(found, what, scenario=track, start=start, **here)
    return falls_short(found, "safedagger")


def test_nowhere() -> None:
    assert shown() == (
        "In the drives after iteration 1: in no case. There are 3 laps without damage in each of 24 cases of seed, "
        "driving strategy, traffic and track."
    )


def test_every_case_is_listed_with_how_its_drives_ended() -> None:
    text = shown(
        (1, "yew", 0, 0, {"laps": 1.0, "off_road": 1.0}),
        (0, "spruce", 1, 0, {"laps": 0.5, "off_road": 0.0}),
        (0, "spruce", 1, 1, {"damage": 7.0}),
    )
    assert text.startswith("In the drives after iteration 1: in 2 of 24 cases of seed,")
    assert "1 ended by leaving the road, 1 stopped short on it" in text
    assert "and 1 hit another car." in text
    assert text.splitlines()[-2:] == [
        "| 0 | naive, with traffic, spruce | 1.75 | 2 | 0 of 2 | 1 of 2 | 1 of 2 |",
        "| 1 | naive, without traffic, yew | 2.00 | 0 | 1 of 2 | 0 of 2 | 0 of 2 |",
    ]


def test_damage_alone_falls_short() -> None:
    text = shown((0, "willow", 1, 0, {"damage": 3.0}))
    assert "| 0 | naive, with traffic, willow | 3.00 | 0.5 | 0 of 2 | 0 of 2 | 1 of 2 |" in text
