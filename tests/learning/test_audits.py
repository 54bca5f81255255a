import numpy as np
import pytest

from pipeline.learning.audits import estimated_recall
from pipeline.learning.quality import detection_quality

TAU, CUT = 0.1, 0.5


def drives(rng: np.random.Generator, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Safe probability and deviation [N]; unsafe frames come in runs, as those of a drive do."""
    unsafe = np.repeat(rng.random(frames // 5) < 0.3, 5)
    probability = np.where(unsafe, rng.beta(1, 2, frames), rng.beta(4, 2, frames))
    return probability, np.where(unsafe, 2 * TAU, TAU / 2)


def audited(
    rng: np.random.Generator, probability: np.ndarray, share: float
) -> tuple[np.ndarray, np.ndarray]:
    """What the safety policy calls unsafe, and what is audited of the rest: bool [N] each."""
    called = probability < CUT
    return called, ~called & (rng.random(len(called)) < share)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("queries", [10_000, 150])
def test_nineteen_intervals_in_twenty_hold_what_all_the_labels_would_tell(
    share: float, queries: int
) -> None:
    """Also where the drives end with a query that spends the budget."""
    rng = np.random.default_rng(0)
    held, off = [], []
    for _ in range(600):
        probability, deviation = drives(rng, 400)
        called, asked = audited(rng, probability, share)
        stop = int(np.searchsorted(np.cumsum(called | asked), queries)) + 1
        probability, deviation, called, asked = (
            each[:stop] for each in (probability, deviation, called, asked)
        )
        told = np.where(called | asked, deviation, np.nan)
        found = estimated_recall(told, called, asked, share, TAU)
        recall = detection_quality(probability, deviation, TAU, CUT)["recall"]
        low, value, high = (found[f"estimated_recall{end}"] for end in ("_low", "", "_high"))
        assert low <= value <= high
        held.append(low <= recall <= high)
        off.append(1 / value - 1 / recall)
    assert np.mean(held) >= 0.95 - 2 * np.sqrt(0.95 * 0.05 / 600)
    assert np.mean(off) == pytest.approx(0, abs=3 * np.std(off) / np.sqrt(600))


def test_where_all_is_audited_nothing_is_left_to_chance() -> None:
    rng = np.random.default_rng(1)
    probability, deviation = drives(rng, 200)
    called, asked = audited(rng, probability, 1.0)
    found = estimated_recall(deviation, called, asked, 1.0, TAU)
    recall = detection_quality(probability, deviation, TAU, CUT)["recall"]
    assert found == {"audits": (~called).sum()} | dict.fromkeys(
        ("estimated_recall", "estimated_recall_low", "estimated_recall_high"), recall
    )


def test_audits_that_missed_nothing_do_not_prove_that_nothing_was_missed() -> None:
    """Of 35 unsafe frames all escape the audits once in forty times, of 36 less often."""
    called = np.arange(400) < 10
    asked = np.arange(400) >= 360
    told = np.where(called, 2 * TAU, np.where(asked, 0.0, np.nan))
    found = estimated_recall(told, called, asked, 0.1, TAU)
    assert (found["estimated_recall"], found["estimated_recall_high"]) == (1, 1)
    assert 0.9**35 > 0.025 > 0.9**36
    assert found["estimated_recall_low"] == pytest.approx(10 / (10 + 35))


def test_nothing_unsafe_seen_is_no_recall() -> None:
    nothing = np.zeros(4, bool)
    found = estimated_recall(np.array([0, np.nan, 0, np.nan]), nothing, ~nothing, 0.5, TAU)
    assert found["audits"] == 4 and found["estimated_recall"] is None
