"""Columns come from the spaces of an environment, by LeRobot's names."""

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict

from pipeline.data.schema import core_features
from pipeline.driving.environment import DrivingEnv
from pipeline.driving.features import ACTIONS, CAMERA, FEATURES
from pipeline.environment import columns_of, features_of
from tests.stages.pendulum import DONE, SEEN, Pendulum

PICTURE = Box(0, 255, (4, 6, 3), np.uint8)
NAMES = ["height", "width", "channel"]


def test_every_picture_the_state_and_the_action_have_their_columns() -> None:
    seen = Dict(
        {
            "pixels": Dict({"left": PICTURE, "right": PICTURE}),
            "agent_pos": Box(-np.inf, np.inf, (2,), np.float32),
        }
    )
    done = Box(np.array([-1, 0], "f4"), np.array([1, 0.5], "f4"))
    found = features_of(seen, done, seen=("x [m]", "y [m]"), does=("turn", "grip"))
    picture = {"dtype": "image", "shape": (4, 6, 3), "names": NAMES}
    action = {"dtype": "float32", "shape": (2,), "names": ["turn", "grip"]}
    assert found == {
        "observation.images.left": picture,
        "observation.images.right": picture,
        "observation.state": {"dtype": "float32", "shape": (2,), "names": ["x [m]", "y [m]"]},
        **core_features(action | {"low": [-1, 0], "high": [1, 0.5]}),
    }
    shown = columns_of(seen.sample())
    assert {name: values.shape for name, values in shown.items()} == {
        name: found[name]["shape"] for name in shown
    }


def test_a_single_picture_and_no_bounds() -> None:
    unbounded = Box(-np.inf, np.inf, (1,), np.float32)
    found = features_of(Dict({"pixels": PICTURE}), unbounded, does=("push [N]",))
    assert found["action"] == {"dtype": "float32", "shape": (1,), "names": ["push [N]"]}
    assert [name for name in found if name.startswith("observation")] == ["observation.image"]


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        ({"seen": ("a",), "does": ("b",)}, r"seen is \['a'\], expected a name for each of \(3,\)"),
        (
            {"seen": ("a", "b", "c"), "does": ()},
            r"does is \[\], expected a name for each of \(1,\)",
        ),
    ],
)
def test_each_number_has_a_name(names: dict, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        features_of(SEEN, DONE, **names)


def test_the_car_and_the_pendulum_are_described_by_their_spaces() -> None:
    car = DrivingEnv()
    found = features_of(car.observation_space, car.action_space, does=ACTIONS)
    assert found == {name: FEATURES[name] for name in found}
    assert CAMERA in found
    env = Pendulum(length=1.0).environment("hold up")
    shown = columns_of(env.reset(seed=0)[0])
    assert all(shown[name].shape == Pendulum.features[name]["shape"] for name in shown)
