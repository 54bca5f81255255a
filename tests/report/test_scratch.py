"""A primary from scratch beside the warm one: pairs of the same starts, and which gets further."""

import pytest

from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.reading import SCRATCH, WARM
from pipeline.report.scratch import warm_or_scratch
from tests.evaluation.made_up import Level, experiment, undriven, without


def pairs(warm: Level, scratch: Level, starts: int = 4) -> Experiment:
    """Iteration 3 both ways."""
    made_up = experiment({WARM: [warm] * 4, SCRATCH: [scratch] * 4}, starts=starts)
    return without(made_up, iteration=[0, 1, 2])


@pytest.mark.parametrize(
    ("warm", "scratch", "starts", "verdict"),
    [
        (2.5, 2.0, 4, "the primary with the warm start gets further"),
        (2.0, 2.5, 4, "the primary trained from scratch gets further"),
        (2.0, 2.0, 4, "which primary gets further is undecided"),
        (2.0, 2.5, 1, "which primary gets further is undecided"),  # three pairs prove nothing
    ],
)
def test_one_sentence_says_which_gets_further(
    warm: float, scratch: float, starts: int, verdict: str
) -> None:
    found = pairs(Level(laps=(warm, warm)), Level(laps=(scratch, scratch)), starts)
    sentence = warm_or_scratch(found).split("\n\n")[0]
    gap = f"{scratch - warm:+.2f}"
    assert sentence == (
        f"On D_3, {verdict}: over both conditions, from scratch minus warm is "
        f"{gap} [{gap}, {gap}] laps, in {3 * starts} pairs of seed, track and start."
    )


def test_laps_and_error_stand_side_by_side_with_their_difference() -> None:
    found = pairs(
        Level(laps=(3.0, 2.0), error=(0.01, 0.02)), Level(laps=(2.5, 2.2), error=(0.02, 0.02))
    )
    *_, first, second, third, fourth = warm_or_scratch(found).splitlines()
    assert first == (
        "| D_3 | laps, without traffic | 3.00 [3.00, 3.00] | 2.50 [2.50, 2.50] | "
        "-0.50 [-0.50, -0.50] |"
    )
    assert second.startswith("| D_3 | laps, with traffic | 2.00 [2.00, 2.00] | 2.20")
    assert third.endswith("| 0.01 [0.01, 0.01] | 0.02 [0.02, 0.02] | +0.01 [+0.01, +0.01] |")
    assert fourth.startswith("| D_3 | steering MSE, with traffic | 0.02 [0.02, 0.02] | 0.02")


def test_what_was_not_driven_is_not_compared() -> None:
    text = warm_or_scratch(undriven(pairs(Level(), Level()), run=SCRATCH, condition="traffic"))
    assert text.startswith("On D_3, no start was given to both.")
    assert "| D_3 | laps, with traffic | 1.50 [1.50, 1.50] | - | - |" in text
