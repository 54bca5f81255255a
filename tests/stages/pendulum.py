"""Another world in one file: a pendulum that is to be held up, with its state and a picture of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import cv2
import numpy as np
from gymnasium.spaces import Box, Dict

from pipeline.data.schema import Feature
from pipeline.environment import Action, Environment, Observation, features_of
from pipeline.settings import Setting
from pipeline.task import Task

SIZE, FPS, FRAMES, GRAVITY = 32, 20, 12, 9.81
SEEN = Dict(
    {
        "pixels": Box(0, 255, (SIZE, SIZE, 3), np.uint8),
        "agent_pos": Box(-np.inf, np.inf, (3,), np.float32),
    }
)
DONE = Box(-1, 1, (1,), np.float32)


class PendulumEnv(Environment):
    """The angle 0 is upright. The action is an acceleration, [-1, 1] times 30 rad/s^2."""

    def __init__(self, length: float, *, upright: bool) -> None:
        self.observation_space, self.action_space = SEEN, DONE
        self._length, self._upright = length, upright
        self._angle = self._speed = 0.0
        self._frames = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._angle = float(self.np_random.normal(0.0 if self._upright else np.pi, 0.1))
        self._speed, self._frames = 0.0, 0
        return self._observation(), self._info(None)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        pull = GRAVITY / self._length * np.sin(self._angle)
        self._speed += float(pull + 30.0 * np.clip(action[0], -1, 1)) / FPS
        self._angle += self._speed / FPS
        self._frames += 1
        over = self._frames >= FRAMES
        info = self._info("out of time" if over else None)
        return self._observation(), 0.0, False, over, info

    def label(self) -> Action:
        return np.clip([-(20 * np.sin(self._angle) + 5 * self._speed) / 30], -1, 1).astype("f4")

    def look_up(self) -> Action:
        return self.label()

    def outcome(self) -> dict[str, float]:
        return {"upright": float(np.cos(self._angle) > 0.9)}

    def _observation(self) -> Observation:
        picture = np.full((SIZE, SIZE, 3), 255, np.uint8)
        tip = SIZE / 2 * (1 + 0.8 * np.array([np.sin(self._angle), -np.cos(self._angle)]))
        cv2.line(picture, (SIZE // 2, SIZE // 2), tuple(tip.astype(int).tolist()), (0, 0, 0), 2)
        state = [np.cos(self._angle), np.sin(self._angle), self._speed]
        return {"pixels": picture, "agent_pos": np.array(state)}

    def _info(self, ended: str | None) -> dict[str, Any]:
        return {"hidden": {}, "ended": ended, "failed": False}


@dataclass(frozen=True, kw_only=True)
class Pendulum(Task):
    """How long it is."""

    name: ClassVar[str] = "tests.stages.pendulum:Pendulum"
    robot: ClassVar[str] = "pendulum"
    features: ClassVar[Mapping[str, Feature]] = features_of(
        SEEN, DONE, seen=("cosine", "sine", "speed [rad/s]"), does=("acceleration [30 rad/s^2]",)
    )
    failures: ClassVar[Mapping[str, str]] = {"hangs": "upright == 0"}

    length: Annotated[float, Setting("Of the pendulum [m].", 0)]

    @property
    def fps(self) -> int:
        return FPS

    @property
    def scenarios(self) -> list[str]:
        return ["swing up", "hold up"]

    def describe(self, scenario: str) -> str:
        return f"{scenario} a pendulum of {self.length} m"

    def environment(self, scenario: str) -> Environment:
        return PendulumEnv(self.length, upright=scenario == "hold up")


@dataclass(frozen=True, kw_only=True)
class Helped(Pendulum):
    """By somebody who has to be asked, as a person has."""

    name: ClassVar[str] = "tests.stages.pendulum:Helped"
    can_look_up: ClassVar[bool] = False
