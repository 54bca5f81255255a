"""The driving world as a Gymnasium environment: for our closed loop, and for any other learner.

Importing this module registers it:

    gymnasium.make("pipeline.driving.environment:safedagger/Driving-v0", track="alder", traffic=40)
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from pipeline.driving.features import (
    CONTROL_HZ,
    HIGH,
    IMAGE_SHAPE,
    LOW,
    STANDSTILL,
    check_action_repeat,
)
from pipeline.driving.reference import reference_actions
from pipeline.driving.tracks import make_track
from pipeline.driving.traffic import Begins, check_room
from pipeline.driving.world import World
from pipeline.environment import Action, Environment, Observation

MOVING = 0.5  # [m/s] that count as such

Step = tuple[Observation, float, bool, bool, dict[str, Any]]


class DrivingEnv(Environment):
    """Drive car 0 with the front camera, among cars that the reference drives.

    Observation: {"pixels": {"front": uint8 [72, 160, 3]}}, RGB. Action: float32 [2], steering in
    [-1, 1], where 1 is full lock to the left, and brake, on above 0.5. It is held for the
    `action_repeat` control steps of 1/30 s of a frame, to the end, even off the road.

    The reward is the paper's implicit one (Sec. 2.1) as far as it can be told frame by frame: -1 at
    the first failure, which is leaving the road or touching another car, and 0 everywhere else. So
    the return of an episode is r - 1, with r = 1 for a drive without a crash and 0 for any other.

    An episode is terminated when the road is left, and truncated after `laps`, ten seconds of
    standing still, or `seconds`. For `info` see `Environment`; hidden are "affordances" [10] and
    "vehicle_state" [4].
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": CONTROL_HZ}  # noqa: RUF012

    def __init__(
        self,
        *,
        track: str = "alder",
        traffic: int = 0,
        spread: tuple[float, float] = (0.3, 0.05),
        begins: Begins = "anywhere",
        action_repeat: int = 1,
        laps: float = 3.0,
        seconds: float = 300.0,
        render_mode: str | None = None,
    ) -> None:
        """A track by its name, with `traffic` other cars.

        Our car starts off its lane by `spread` (standard deviations in m and rad), anywhere or on
        the start line.

        Raises:
            ValueError: unknown track, no room for so many cars, or a time or distance of 0.
        """
        if laps <= 0 or seconds <= 0:
            raise ValueError(f"laps {laps}, seconds {seconds}: expected more than 0")
        self.observation_space = Dict(
            {"pixels": Dict({"front": Box(0, 255, IMAGE_SHAPE, np.uint8)})}
        )
        self.action_space = Box(np.array(LOW, np.float32), np.array(HIGH, np.float32))
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": check_action_repeat(action_repeat)}
        self._track = make_track(track)
        check_room(self._track, traffic)
        self._traffic, self._spread, self._begins = traffic, spread, begins
        self._action_repeat, self._laps = action_repeat, laps
        self._most_frames = int(seconds * CONTROL_HZ / action_repeat)
        self._frames = 0
        self._standing = 0.0
        self._failed = self._off_road = False
        self._actions: NDArray[np.float32] = np.zeros((0, 2), np.float32)
        """[N, 2], what the reference would do in each car's place now"""
        self._world: World | None = None

    @property
    def world(self) -> World:
        """The true state.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self._world is None:
            raise gymnasium.error.ResetNeeded("reset() starts a drive, and must come first")
        return self._world

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start a new drive at random. Equal seeds give equal drives, bit for bit."""
        super().reset(seed=seed)
        self.close()
        self._world = World(
            self._track, self._traffic, self._spread, self.np_random, begins=self._begins
        )
        self._frames, self._standing, self._failed = 0, 0.0, False
        self._off_road = self._world.off_road
        self._actions = reference_actions(self._world.cars, self._track)
        return self._observation(), self._info(None)

    def step(self, action: Action) -> Step:
        """Drive one frame."""
        world = self.world
        for _ in range(self._action_repeat):
            self._actions[0] = action
            world.step(self._actions)
            self._actions = reference_actions(world.cars, self._track)
        self._frames += 1
        moving = world.cars.speed[0] >= MOVING
        self._standing = 0.0 if moving else self._standing + self._action_repeat / CONTROL_HZ
        self._off_road = world.off_road
        failed = self._off_road or world.damage > 0
        reward = -1.0 if failed and not self._failed else 0.0
        self._failed = failed
        ended = self._ended()
        over = ended is not None and not self._off_road
        return self._observation(), reward, self._off_road, over, self._info(ended)

    def label(self) -> Action:
        """The reference's steering and brake, [2]."""
        return self._actions[0].copy()

    def look_up(self) -> Action:
        """The same: the simulator knows it at any time."""
        return self._actions[0].copy()

    def outcome(self) -> dict[str, float]:
        """Laps, those that were asked for at most; metres driven (negative: backwards); damage
        [m^2/s^2]; touches; off the road.
        """
        world = self.world
        return {
            "laps": min(max(world.laps, 0.0), self._laps),
            "distance_m": world.distance,
            "damage": world.damage,
            "touches": world.touches,
            "off_road": self._off_road,
        }

    def render(self) -> NDArray[np.uint8] | None:
        """What the camera sees, uint8 [72, 160, 3], in render mode "rgb_array"."""
        return self.world.image() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """End the drive; its scene waits for another one, in this environment or the next."""
        if self._world is not None:
            self._world.close()
            self._world = None

    def _ended(self) -> str | None:
        if self._off_road:
            return "road left"
        if self.world.laps >= self._laps:
            return "laps done"
        if self._standing >= STANDSTILL:
            return "stood still"
        return "out of time" if self._frames >= self._most_frames else None

    def _observation(self) -> Observation:
        return {"pixels": {"front": self.world.image()}}

    def _info(self, ended: str | None) -> dict[str, Any]:
        world = self.world
        hidden = {"affordances": world.affordances(), "vehicle_state": world.vehicle_state()}
        failed = ended in ("road left", "stood still")
        return {"hidden": hidden, "ended": ended, "failed": failed}


gymnasium.register("safedagger/Driving-v0", entry_point="pipeline.driving.environment:DrivingEnv")
