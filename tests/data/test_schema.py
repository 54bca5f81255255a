import numpy as np
import pytest

from pipeline.data.schema import Episode
from pipeline.driving.features import CAMERA, FEATURES, check_action_repeat
from tests.episodes import random_episode


@pytest.fixture
def episode() -> Episode:
    return random_episode(np.random.default_rng(0), 5, first_frame=7)


def test_only_the_camera_and_the_action_look_like_a_policys_business() -> None:
    # LeRobot gives a policy whatever begins with these, and takes any "image" for a picture
    assert [name for name in FEATURES if name.startswith(("observation", "action"))] == [
        CAMERA,
        "action",
    ]
    assert [name for name in FEATURES if "image" in name] == [CAMERA]


def test_only_dtypes_that_rerun_accepts() -> None:
    assert {FEATURES[name]["dtype"] for name in FEATURES.keys() - {CAMERA}} <= {
        "bool",
        "float32",
        "int64",
    }


def test_rows_are_a_part_of_every_column(episode: Episode) -> None:
    part = episode.rows(1, 3)
    assert len(part) == 2
    assert part.task == episode.task
    for name in FEATURES:
        np.testing.assert_array_equal(part.columns[name], episode.columns[name][1:3])
    assert part.columns["source.frame"][:, 0].tolist() == [8, 9]


def test_no_rows_are_no_episode(episode: Episode) -> None:
    with pytest.raises(ValueError, match="no rows"):
        episode.rows(2, 2)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("action", np.zeros((5, 2)), "'action' of the episode is float64"),
        ("action", np.zeros((5, 3), np.float32), r"\(5, 3\), expected float32 \(5, 2\)"),
        ("action", np.zeros((4, 2), np.float32), r"\(4, 2\), expected float32 \(5, 2\)"),
        ("intervention", np.zeros(5, bool), r"bool \(5,\), expected bool \(5, 1\)"),
        ("queried", np.zeros((5, 1), np.int64), "int64 .* expected bool"),
        ("source.frame", np.zeros((5, 1), np.int32), "int32 .* expected int64"),
        (CAMERA, np.zeros((5, 3, 72, 160), np.uint8), "expected uint8"),
        ("speed", np.zeros((5, 1), np.float32), "'speed' of the episode is unknown"),
    ],
)
def test_refuses_a_wrong_column(
    episode: Episode, name: str, value: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Episode("coast", {**episode.columns, name: value}, FEATURES)


@pytest.mark.parametrize("name", FEATURES)
def test_refuses_a_missing_column(episode: Episode, name: str) -> None:
    rest = {other: values for other, values in episode.columns.items() if other != name}
    with pytest.raises(ValueError, match=f"{name!r} of the episode is missing"):
        Episode("coast", rest, FEATURES)


def test_refuses_no_task(episode: Episode) -> None:
    with pytest.raises(ValueError, match="task is ''"):
        Episode("", episode.columns, FEATURES)


@pytest.mark.parametrize(("action_repeat", "fps"), [(1, 30), (3, 10), (30, 1)])
def test_fps_is_the_control_rate_over_action_repeat(action_repeat: int, fps: int) -> None:
    assert check_action_repeat(action_repeat) == fps


@pytest.mark.parametrize("action_repeat", [0, -3, 4, 60])
def test_refuses_an_action_repeat_without_a_whole_fps(action_repeat: int) -> None:
    with pytest.raises(ValueError, match=f"action_repeat is {action_repeat}, expected a divisor"):
        check_action_repeat(action_repeat)
