"""Against NumPy, and against LeRobot's own."""

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


@given(columns, columns)
def test_of_numbers_they_are_numpys(one: np.ndarray, other: np.ndarray) -> None:
    other = np.resize(other, (len(one), 2))
    found = statistics.of_columns({"one": one, "other": other})
    for name, values in (("one", one.astype(float)), ("other", other.astype(float))):
        of = found[name]
        assert of is not None and set(of) == set(NAMES)
        assert of["count"] == [len(values)]
        for key in ("min", "max", "mean", "std"):
            np.testing.assert_allclose(of[key], getattr(values, key)(axis=0))
        for key, share in QUANTILES.items():
            np.testing.assert_allclose(of[key], np.quantile(values, share, axis=0))


def test_rows_without_a_value_do_not_count() -> None:
    values = np.array([[1, np.nan], [2, 4], [4, 8]], np.float32)
    found = statistics.of_columns({"some": values, "none": np.full((3, 1), np.nan)})
    assert found["none"] is None
    assert found["some"] is not None
    assert (found["some"]["min"], found["some"]["count"]) == ([2, 4], [2])


@pytest.mark.parametrize("frames", [1, 7])
def test_of_images_they_are_lerobots(frames: int) -> None:
    from lerobot.datasets import get_feature_stats

    images = np.random.default_rng(0).integers(0, 256, (frames, 8, 9, 3), np.uint8)
    ours = statistics.of_images(list(images))
    theirs = get_feature_stats(images.transpose(0, 3, 1, 2), axis=(0, 2, 3), keepdims=True)
    assert ours["count"] == [frames]
    for name in NAMES:
        if name != "count":
            # theirs are of a histogram that does not know that pixels are whole numbers
            expected = theirs[name].reshape(3, 1, 1) / 255
            np.testing.assert_allclose(
                ours[name], expected, atol=0.02 if name in QUANTILES else 1e-6
            )


def test_of_episodes_they_aggregate_as_lerobots() -> None:
    from lerobot.datasets import aggregate_stats

    rng = np.random.default_rng(1)
    parts = [
        statistics.of_images(list(rng.integers(0, 256, (n, 4, 5, 3), np.uint8))) for n in (1, 5)
    ]
    theirs = aggregate_stats([{"a": {k: np.array(v) for k, v in part.items()}} for part in parts])
    ours = statistics.aggregate(parts)
    for name in NAMES:
        np.testing.assert_allclose(ours[name], theirs["a"][name])
