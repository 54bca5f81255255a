"""MetaWorld's tasks of a robot arm, through LeRobot. Their reference is MetaWorld's own scripted one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from gymnasium.spaces import Box, Dict

from pipeline.data.schema import Feature
from pipeline.environment import Environment, features_of
from pipeline.metric import DRIVEN, EVERYWHERE, Metric
from pipeline.settings import Setting, listed
from pipeline.task import Task

SIZE = 84
"""Of the picture [pixels]."""
LONGEST = 500
"""Actions after which MetaWorld itself goes no further."""
HAND = ("x", "y", "z", "gripper")
"""Its place [m] and how far the gripper is open; of an action by how much it moves, and 1 closes it."""
SEEN = Dict(
    {
        "pixels": Box(0, 255, (SIZE, SIZE, 3), np.uint8),
        "agent_pos": Box(-1000, 1000, (4,), np.float32),
    }
)
DONE = Box(-1, 1, (4,), np.float32)
_OBJECT = ("x", "y", "z", "q1", "q2", "q3", "q4")


@dataclass(frozen=True, kw_only=True)
class MetaWorld(Task):
    """What the arm is to do, from where, and for how long.

    Raises:
        ValueError: MetaWorld has no such task, or a number is out of its range.
        OSError: MetaWorld is not installed, or finds nothing to draw with.
    """

    name: ClassVar[str] = "metaworld"
    robot: ClassVar[str] = "sawyer"
    metrics: ClassVar[Mapping[str, Metric]] = {
        "success": Metric(
            "Success", "share of drives", "share", "success", shown=(*EVERYWHERE, "dvc")
        ),
        "steps": Metric("Frames of a drive", "frames", "amount", "frames"),
        **DRIVEN,
    }
    features: ClassVar[Mapping[str, Feature]] = {
        **features_of(SEEN, DONE, seen=HAND, does=HAND),
        # two objects at most, 0 where there is none, and where to bring them
        "object_state": {
            "dtype": "float32",
            "shape": (17,),
            "names": [f"{part}_{n}" for n in (1, 2) for part in _OBJECT]
            + ["goal_x", "goal_y", "goal_z"],
        },
    }

    tasks: Annotated[
        str, Setting("MetaWorld's tasks, separated by commas, such as button-press-topdown-v3.")
    ]
    perturb: Annotated[
        int, Setting("Random actions before the first frame, so that starts spread.", 0)
    ] = 0
    steps: Annotated[int, Setting("Most frames (1/80 s) of a drive.", 1)] = 150

    def __post_init__(self) -> None:
        super().__post_init__()
        known = _descriptions()
        for task in self.scenarios:
            if task not in known:
                raise ValueError(
                    f"MetaWorld has no task {task!r}, expected one of {', '.join(known)}"
                )
        if self.perturb + self.steps > LONGEST:
            raise ValueError(
                f"perturb is {self.perturb} and steps is {self.steps}, "
                f"expected at most {LONGEST} together"
            )

    @property
    def fps(self) -> int:
        """Frames per second."""
        return 80

    @property
    def scenarios(self) -> list[str]:
        """MetaWorld's tasks."""
        return listed(self.tasks)

    def describe(self, scenario: str) -> str:
        """What LeRobot says to a policy that reads, such as "Press a button from the top"."""
        return _descriptions()[scenario]

    def environment(self, scenario: str) -> Environment:
        """The task, with its objects elsewhere at each `reset`."""
        from pipeline.tasks.metaworld_environment import MetaWorldEnv

        return MetaWorldEnv(scenario, perturb=self.perturb, steps=self.steps)


def _descriptions() -> dict[str, str]:
    """Of MetaWorld's tasks, by name. The import takes seconds, for which `--help` need not wait."""
    try:
        from lerobot.envs.metaworld import TASK_DESCRIPTIONS
    except (ImportError, AttributeError) as error:  # the latter where MuJoCo finds no EGL
        raise OSError(
            f"MetaWorld cannot be loaded ({error}): it needs pip install 'safedagger[metaworld]', "
            "and on Debian apt-get install libegl1 libgl1-mesa-dri libopengl0"
        ) from None
    return TASK_DESCRIPTIONS
