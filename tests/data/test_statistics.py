"""Against NumPy, and against LeRobot's own."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.data import statistics
from pipeline.data.statistics import NAMES, QUANTILES

columns = arrays(
    np.float32,
    st.tuples(st.integers(1, 30), st.integers(1, 3)),
    elements=st.floats(-9, 9, width=32),
)


@given(columns, columns, st.data())
def test_of_numbers_they_are_numpys(
    one: np.ndarray, other: np.ndarray, data: st.DataObject
) -> None:
    """Of each episode, however many there are and of whatever lengths."""
    other = np.resize(other, (len(one), 2))
    cuts = data.draw(st.sets(st.integers(1, len(one) - 1)) if len(one) > 1 else st.just(set()))
    bounds = [0, *sorted(cuts), len(one)]
    found = statistics.of_columns({"one": one, "other": other}, np.diff(bounds))
    for name, values in (("one", one.astype(float)), ("other", other.astype(float))):
        of = found[name]
        assert set(of) == set(NAMES)
        for episode, (start, stop) in enumerate(pairwise(bounds)):
            rows = values[start:stop]
            assert of["count"][episode] == stop - start
            for key in ("min", "max", "mean", "std"):
                np.testing.assert_allclose(of[key][episode], getattr(rows, key)(axis=0))
            for key, share in QUANTILES.items():
                np.testing.assert_allclose(of[key][episode], np.quantile(rows, share, axis=0))


def test_rows_without_a_value_do_not_count() -> None:
    values = np.array([[1, np.nan], [2, 4], [4, 8], [np.nan, 0]], np.float32)
    found = statistics.of_columns({"some": values, "none": np.full((4, 1), np.nan)}, [3, 1])
    assert found["none"]["count"].tolist() == [[0], [0]]
    assert found["some"]["count"].tolist() == [[2], [0]]
    assert found["some"]["min"][0].tolist() == [2, 4]
    assert np.isnan(found["some"]["mean"][1]).all()


@pytest.mark.parametrize("frames", [1, 7])
def test_of_images_they_are_lerobots(frames: int) -> None:
    from lerobot.datasets import get_feature_stats

    images = np.random.default_rng(0).integers(0, 256, (frames, 8, 9, 3), np.uint8)
    ours = statistics.of_images(images)
    theirs = get_feature_stats(images.transpose(0, 3, 1, 2), axis=(0, 2, 3), keepdims=True)
    assert ours["count"] == [[frames]]
    for name in NAMES:
        if name != "count":
            # theirs are of a histogram that does not know that pixels are whole numbers
            expected = theirs[name].reshape(1, 3) / 255
            np.testing.assert_allclose(
                ours[name], expected, atol=0.02 if name in QUANTILES else 1e-6
            )


def test_of_episodes_they_aggregate_as_lerobots() -> None:
    from lerobot.datasets import aggregate_stats

    rng = np.random.default_rng(1)
    parts = [statistics.of_images(rng.integers(0, 256, (n, 4, 5, 3), np.uint8)) for n in (1, 5)]
    theirs = aggregate_stats([{"a": {k: of[0] for k, of in part.items()}} for part in parts])
    ours = statistics.aggregate(statistics.joined(parts))
    for name in NAMES:
        np.testing.assert_allclose(ours[name][0], theirs["a"][name])
