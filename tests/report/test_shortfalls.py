"""Where a run falls short: by seed, strategy, condition and track, with how the drives ended; and what
SafeDAgger is short of, in numbers of the experiment.
"""

from pipeline.evaluation.experiment import ROLLOUT, Experiment
from pipeline.report.shortfalls import falls_short, limits
from tests.evaluation.made_up import FULL, GROWING, SLOW, experiment, judged, redriven, with_optimal


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


def limits_of(made_up: Experiment) -> str:
    return limits(made_up, "safedagger")


def in_rollouts(made_up: Experiment) -> Experiment:
    """Iterations 0, 1 and 2 decided in a rollout; seed 1 better than seed 0."""
    return judged(
        made_up,
        ROLLOUT,
        {
            "recall": lambda of: of.iteration.map({0: 0.5, 1: 0.3, 2: 0.4}) + 0.1 * of.seed,
            "auroc": lambda of: of.iteration.map({0: 0.7, 1: 0.6, 2: 0.8}) + 0.1 * of.seed,
        },
    )


def made_up() -> Experiment:
    return experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)


def test_each_limit_has_its_numbers() -> None:
    optimal = with_optimal(in_rollouts(made_up()), takeover_frames=150, primary_frames=850)
    found, takeover, steering = limits_of(optimal).splitlines()
    assert "called unsafe 35.0 % to 55.0 % of the truly unsafe frames" in found
    assert "an AUROC of 0.65 to 0.85 (" in found
    assert takeover.startswith("- After iteration 3, the reference drives 2.0 % and 5.0 % of the")
    assert "and 15.0 % and 15.0 % under the optimal one" in takeover
    assert "driven naively, is 0.005 and 0.006" in steering
    assert steering.endswith("and 0.015 and 0.024 in DAgger.")


def test_what_was_not_measured_has_no_point() -> None:
    (only,) = limits_of(made_up()).splitlines()
    assert "steering MSE" in only
    assert limits_of(experiment({"safedagger": GROWING})) == ""


def test_a_single_rollout_has_no_range() -> None:
    once = experiment({"safedagger": GROWING[:1]})
    assert "unsafe 50.0 % of the truly" in limits_of(in_rollouts(once))
