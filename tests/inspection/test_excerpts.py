"""Takeover windows."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipeline.inspection.excerpts import Takeover, takeovers

FRAMES = st.tuples(
    st.booleans(),
    st.one_of(st.just(np.nan), st.floats(0, 1)),
    st.integers(0, 1),  # episodes that the row is after the last one
)


def columns(drove: np.ndarray, probability: np.ndarray) -> dict[str, np.ndarray]:
    """The reference was asked where it drove; the deviation is a tenth of the row."""
    return {
        "intervention": drove,
        "queried": drove,
        "safe_probability": probability,
        "deviation": np.where(drove, np.arange(len(drove)) / 10, np.nan),
    }


def test_most_unsafe_first_two_seconds_before_one_second_after() -> None:
    drove = np.zeros(60, bool)
    drove[[25, 26, 45]] = True
    probability = np.full(60, 0.9)
    probability[[25, 26, 45]] = 0.4, 0.3, 0.1
    found = takeovers(columns(drove, probability), np.zeros(60, np.int64), fps=10)
    assert found == [
        Takeover(0, 45, 46, 25, 56, 0.1, 4.5, 1),
        Takeover(0, 25, 27, 5, 37, 0.3, 2.6, 2),
    ]
    assert str(found[1]) == (
        "episode 0, frames 25 to 26: safe probability 0.300, deviation 2.6000, 2 queries"
    )


@given(st.lists(FRAMES, min_size=1, max_size=80), st.sampled_from([1, 3, 10, 30]))
def test_windows(frames: list[tuple[bool, float, int]], fps: int) -> None:
    """Each is within its episode; what was driven without a safety policy is in none."""
    drove, probability, steps = (np.array(column) for column in zip(*frames, strict=True))
    episode_index = np.cumsum(steps) - steps[0]
    found = takeovers(columns(drove, probability), episode_index, fps=fps)
    taken = drove & ~np.isnan(probability)
    seen = np.zeros(len(frames), int)
    for takeover in found:
        rows = np.flatnonzero(episode_index == takeover.episode)
        assert 0 <= takeover.first <= takeover.start < takeover.stop <= takeover.end <= len(rows)
        assert takeover.first in (0, takeover.start - 2 * fps)
        assert takeover.end in (len(rows), takeover.stop + fps)
        driven = rows[takeover.start : takeover.stop]
        seen[driven] += 1
        for beside in (takeover.start - 1, takeover.stop):
            assert not 0 <= beside < len(rows) or not taken[rows[beside]]
        assert takeover.safe_probability == probability[driven].min()
        assert (takeover.deviation, takeover.queries) == (driven[-1] / 10, len(driven))
    assert np.array_equal(seen, taken.astype(int))
    order = [takeover.safe_probability for takeover in found]
    assert order == sorted(order)
