"""A task of MetaWorld as an environment that knows a reference."""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any

import metaworld
import numpy as np
from lerobot.envs.metaworld import MetaworldEnv
from numpy.typing import NDArray

from pipeline.environment import Action, Environment, Observation
from pipeline.tasks.metaworld import DONE, SEEN, SIZE


class MetaWorldEnv(MetaworldEnv, Environment):
    """LeRobot's environment: small, fast, with a reference, and not in the next episode by itself.

    Observation: {"pixels": uint8 [84, 84, 3], RGB; "agent_pos": float32 [4], the hand's place [m]
    and how far its gripper is open, [0, 1]}. Action: float32 [4], by how much the hand moves and
    what the gripper does (1 closes it), in [-1, 1]. The reward is MetaWorld's own.

    A drive is terminated by success, and truncated after `steps`. For `info` see `Environment`;
    hidden is "object_state" [17].

    What draws is made at the first `reset`, so in the process that drives. Where there is no
    display, the variable MUJOCO_GL must be "egl" by then; our commands set it.
    """

    _env: Any  # MetaWorld's own; None where there is none

    def __init__(self, task: str, *, perturb: int = 0, steps: int = 150) -> None:
        """One of MetaWorld's tasks; `perturb` random actions come before the first frame."""
        super().__init__(
            task, obs_type="pixels_agent_pos", observation_width=SIZE, observation_height=SIZE
        )
        self.observation_space, self.action_space = SEEN, DONE
        self._perturb, self._most_frames = perturb, steps
        self._raw: NDArray[np.float64] = np.zeros(39)
        """MetaWorld's own observation: hand, gripper, objects; the same a step before; goal"""
        self._frames = 0
        self._success = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start a new drive at random. Equal seeds give equal drives, bit for bit."""
        observation, _ = super().reset(seed=seed)
        self._frames, self._success = 0, False
        if self._perturb:
            # MetaWorld places its objects by the same seed: this must not draw the same numbers
            (rng,) = self.np_random.spawn(1)
            for action in rng.uniform(-1, 1, (self._perturb, 4)):
                raw = self._env.step(action)[0]
            observation = self._format_raw_obs(raw)
        return observation, self._info(None)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive one frame. LeRobot's own would reset on success, before anybody saw what came of it."""
        raw, reward, _, _, told = self._env.step(action)
        self._frames += 1
        self._success = bool(told["success"])
        over = not self._success and self._frames >= self._most_frames
        ended = "success" if self._success else "out of time" if over else None
        observation = self._format_raw_obs(raw)
        return observation, float(reward), self._success, over, self._info(ended)

    def label(self) -> Action:
        """What MetaWorld's scripted policy does, [4] in [-1, 1]."""
        with warnings.catch_warnings():
            # it warns that it asks for more than an arm can do
            warnings.simplefilter("ignore", UserWarning)
            # of a copy: those that open and close doors write into what they are given
            action = self.expert_policy.get_action(self._raw.copy())
        return np.clip(action, -1, 1).astype(np.float32)

    def look_up(self) -> Action:
        """The same: the simulator knows it at any time."""
        return self.label()

    def outcome(self) -> dict[str, float]:
        """Whether it succeeded."""
        return {"success": self._success}

    def close(self) -> None:
        """Free the simulator and what draws it."""
        viewer = self._viewer()
        if viewer is not None:
            viewer.con.free()  # else it is freed in the context of whichever is drawing by then
        super().close()
        self._env = None

    def _ensure_env(self) -> None:
        """As LeRobot's own, which draws 480 x 480 whatever it was told, at 4 frames per second."""
        if self._env is not None:
            return
        benchmark = _benchmark(self.task)
        env = benchmark.train_classes[self.task](
            render_mode="rgb_array",
            camera_name=self.camera_name,
            width=self.observation_width,
            height=self.observation_height,
        )
        env.set_task(benchmark.train_tasks[0])
        env.model.cam_pos[2] = [0.75, 0.075, 0.7]
        # a picture of any size takes 0.2 s with shadows, smooth edges and mirrors, and 8 ms without
        env.model.vis.quality.shadowsize = env.model.vis.quality.offsamples = 0
        env.model.mat_reflectance[:] = 0
        env.reset()
        env._freeze_rand_vec = False  # objects elsewhere at each reset,
        env.seeded_rand_vec = True  # as its seed has it
        self._env = env

    def _format_raw_obs(self, raw_obs: NDArray[np.float64]) -> Observation:
        self._raw = raw_obs
        self._viewer()
        observation = super()._format_raw_obs(raw_obs)
        return observation | {"agent_pos": observation["agent_pos"].astype(np.float32)}

    def _viewer(self) -> Any:
        """What draws, if it has been made. Gymnasium leaves it to chance which of several is current."""
        viewer = None if self._env is None else self._env.mujoco_renderer.viewer
        if viewer is not None:
            viewer.make_context_current()
        return viewer

    def _info(self, ended: str | None) -> dict[str, Any]:
        state = np.concatenate([self._raw[4:18], self._raw[-3:]]).astype(np.float32)
        return {
            "hidden": {"object_state": state},
            "ended": ended,
            "failed": ended == "out of time",
        }


@cache
def _benchmark(task: str) -> metaworld.MT1:
    """Draws fifty layouts, which takes half a second; an environment begins with any of them."""
    return metaworld.MT1(task, seed=42)
