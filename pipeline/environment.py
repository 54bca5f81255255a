"""A world as it is driven: a Gymnasium environment that knows a reference.

In the shapes, A is the number of numbers in an action.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

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
