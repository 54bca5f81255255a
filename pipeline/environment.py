"""A world as it is driven: a Gymnasium environment that knows a reference.

In the shapes, A is the number of numbers in an action.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from pipeline.data.schema import Feature, core_features

Action = NDArray[np.float32]
"""[A]"""
Observation = dict[str, Any]
"""As LeRobot's environments have it: "pixels", a picture or pictures by camera; "agent_pos"."""


class Environment(gymnasium.Env[Observation, Action], ABC):
    """One drive after the other. A `step` is a frame: whoever drives decides once in each.

    The `info` of `reset` and `step` tells of the moment of their observation:

    - "hidden": by column, what no policy sees but datasets keep;
    - "ended": why the drive is over, in words, once it is terminated or truncated;
    - "failed": whether somebody has to put the robot back then.
    """

    @abstractmethod
    def label(self) -> Action:
        """What the reference does in the present state. Asking changes nothing, and costs a query."""

    def look_up(self) -> Action:
        """The same, to measure with and never to train on; free, where a task `can_look_up`."""
        raise NotImplementedError("this reference cannot be looked up")

    @abstractmethod
    def outcome(self) -> dict[str, float]:
        """What the drive has come to so far, by name."""


def columns_of(observation: Observation) -> dict[str, NDArray]:
    """An observation by LeRobot's names of its columns (its docs on environments say which)."""
    pixels = observation.get("pixels", {})
    pictures = pixels.items() if isinstance(pixels, Mapping) else [("", pixels)]
    columns = {
        f"observation.images.{camera}" if camera else "observation.image": picture
        for camera, picture in pictures
    }
    if "agent_pos" in observation:
        columns["observation.state"] = np.asarray(observation["agent_pos"], np.float32)
    return columns


def features_of(
    observation: Dict, action: Box, *, seen: Sequence[str] = (), does: Sequence[str]
) -> dict[str, Feature]:
    """The columns of what an environment shows, and the core columns, as LeRobot describes them; ValueError
    unless there are as many names as numbers.

    Args:
        observation: the space of an `Observation`.
        action: the space of an `Action`; where it is bounded, its numbers are measured by that.
        seen: what the numbers of "agent_pos" are, with units: "speed [m/s]".
        does: what those of the action are.
    """
    pixels = observation.spaces.get("pixels", Dict())
    cameras = pixels.spaces if isinstance(pixels, Dict) else {"": pixels}
    features: dict[str, Feature] = {
        f"observation.images.{camera}" if camera else "observation.image": {
            "dtype": "image",
            "shape": space.shape,
            "names": ["height", "width", "channel"],
        }
        for camera, space in cameras.items()
    }
    if "agent_pos" in observation.spaces:
        features["observation.state"] = _numbers("seen", observation["agent_pos"], seen)
    done = dict(_numbers("does", action, does))
    if action.is_bounded():
        done |= {"low": action.low.tolist(), "high": action.high.tolist()}
    return {**features, **core_features(done)}


def _numbers(what: str, space: Space[Any], names: Sequence[str]) -> Feature:
    if space.shape != (len(names),):
        raise ValueError(f"{what} is {list(names)}, expected a name for each of {space.shape}")
    return {"dtype": "float32", "shape": space.shape, "names": list(names)}
