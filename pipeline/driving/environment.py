"""The world as a Gymnasium environment, for whoever has a learner of their own.

Importing this module registers it:

    gymnasium.make("pipeline.driving.environment:safedagger/Driving-v0", track="alder", traffic=40)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.envs.registration import load_env_creator
from numpy.typing import NDArray

from pipeline.driving.cars import Cars
from pipeline.driving.features import AFFORDANCES, CONTROL_HZ, IMAGE_SHAPE
from pipeline.driving.tracks import Track, make_track
from pipeline.driving.traffic import check_room
from pipeline.driving.world import World

Actions = NDArray[np.floating]
TrafficDriver = Callable[[Cars, Track], Actions]


class DrivingEnv(gymnasium.Env[NDArray[np.uint8], Actions]):
    """Drive car 0 with the front camera; one step is one control step of 1/CONTROL_HZ s.

    Observation: uint8 [72, 160, 3], RGB. Action: float32 [2], steering in [-1, 1], where 1 is full
    lock to the left, and brake, on above 0.5.

    The reward is the paper's implicit one (Sec. 2.1) as far as it can be told step by step: -1 at
    the first failure, which is leaving the road or touching another car, and 0 everywhere else. So
    the return of an episode is r - 1, with r = 1 for a drive without a crash and 0 for any other.

    An episode is terminated when the road is left, and truncated after `laps` or `max_seconds`.
    `info` holds what no camera sees: every affordance by name, `laps`, `damage` [m^2/s^2],
    `off_road`, `speed` [m/s], and the car's place on the track, `s` [m], `d` [m], `angle` [rad].
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": CONTROL_HZ}  # noqa: RUF012

    def __init__(
        self,
        *,
        traffic_driver: TrafficDriver | str,
        track: str = "alder",
        traffic: int = 0,
        spread: tuple[float, float] = (0.3, 0.05),
        laps: float = 3.0,
        max_seconds: float = 300.0,
        render_mode: str | None = None,
    ) -> None:
        """A track by its name, with `traffic` other cars.

        Our car starts off its lane by `spread` (standard deviations in m and rad). `traffic_driver`
        gives the actions [N, 2] of all cars, of which ours is ignored; it may be given as
        "module:attribute", since the policies that could drive know this package, not it them.

        Raises:
            ValueError: unknown track, no room for so many cars, or a time or distance of 0.
        """
        if laps <= 0 or max_seconds <= 0:
            raise ValueError(f"laps {laps}, max_seconds {max_seconds}: expected more than 0")
        self.observation_space = gymnasium.spaces.Box(0, 255, IMAGE_SHAPE, np.uint8)
        self.action_space = gymnasium.spaces.Box(
            np.array([-1, 0], np.float32), np.array([1, 1], np.float32)
        )
        self.render_mode = render_mode
        self._track = make_track(track)
        check_room(self._track, traffic)
        self._traffic = traffic
        if isinstance(traffic_driver, str):
            traffic_driver = cast(TrafficDriver, load_env_creator(traffic_driver))
        self._driver = traffic_driver
        self._spread = spread
        self._laps = laps
        self._max_steps = round(max_seconds * CONTROL_HZ)
        self._steps = 0
        self._failed = False
        self.world: World | None = None
        """the true state; None before the first reset"""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.uint8], dict[str, Any]]:
        """Start a new drive at random. Equal seeds give equal drives, bit for bit."""
        super().reset(seed=seed)
        self.close()
        self.world = World(self._track, self._traffic, self._spread, self.np_random)
        self._steps, self._failed = 0, False
        return self.world.image(), self._info(self.world)

    def step(self, action: Actions) -> tuple[NDArray[np.uint8], float, bool, bool, dict[str, Any]]:
        """Advance by one control step."""
        world = self._started()
        actions = self._driver(world.cars, world.track)
        actions[0] = action
        world.step(actions)
        self._steps += 1
        failed = world.off_road or world.damage > 0
        reward = -1.0 if failed and not self._failed else 0.0
        self._failed = failed
        truncated = world.laps >= self._laps or self._steps >= self._max_steps
        return world.image(), reward, world.off_road, truncated, self._info(world)

    def render(self) -> NDArray[np.uint8] | None:
        """What the camera sees, uint8 [72, 160, 3], in render mode "rgb_array"."""
        return self._started().image() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Free the PyBullet client."""
        if self.world is not None:
            self.world.scene.close()
            self.world = None

    def _started(self) -> World:
        if self.world is None:
            raise gymnasium.error.ResetNeeded("reset() starts a drive, and must come first")
        return self.world

    def _info(self, world: World) -> dict[str, Any]:
        return {
            **dict(zip(AFFORDANCES, world.affordances().tolist(), strict=True)),
            "laps": world.laps,
            "damage": world.damage,
            "off_road": world.off_road,
            "speed": float(world.cars.speed[0]),
            "s": float(world.cars.s[0]),
            "d": float(world.cars.d[0]),
            "angle": float(world.cars.angle(world.track)[0]),
        }


gymnasium.register(
    "safedagger/Driving-v0",
    entry_point="pipeline.driving.environment:DrivingEnv",
    kwargs={"traffic_driver": "pipeline.driving.reference:reference_actions"},
)
