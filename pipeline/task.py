"""The seam to a world: what a robot sees and does there, who can be asked, what a drive comes to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from pipeline.data.schema import Feature
from pipeline.metric import DRIVEN, Metric
from pipeline.registry import TASKS, find_subclass
from pipeline.settings import Settings

if TYPE_CHECKING:
    from pipeline.environment import Environment


@dataclass(frozen=True)
class Task(Settings, ABC):
    """A world with its settings; it can be pickled, and makes its environments where they are driven.

    A subclass is a frozen dataclass: its fields, each with a `settings.Setting`, are what commands
    take.
    """

    name: ClassVar[str]
    robot: ClassVar[str]
    """LeRobot's `robot_type`"""
    features: ClassVar[Mapping[str, Feature]]
    """all columns of its datasets: observations, core, hidden; an action's numbers range from its
    "low" to its "high", from -1 to 1 if it has none"""
    measure: ClassVar[str] = "mean-square"
    """epsilon of Sec. 3.1, how far two of its actions are apart: see `policies.measures`"""
    can_look_up: ClassVar[bool] = True
    """whether its reference answers for nothing: a rule in a simulator does, a person does not"""
    metrics: ClassVar[Mapping[str, Metric]] = DRIVEN
    """what its drives are measured by, of what their `outcome` and all drives have"""
    failures: ClassVar[Mapping[str, str]] = {}
    """what may go wrong in a drive, by name: how often it did, as a `metric.Metric` takes it of drives"""

    @property
    @abstractmethod
    def fps(self) -> int:
        """Frames per second."""

    @property
    @abstractmethod
    def scenarios(self) -> list[str]:
        """The names of the situations that it can be driven in."""

    @property
    def conditions(self) -> Mapping[str, Task]:
        """The task as it is to be evaluated, by the name of the condition; here as it is."""
        return {"as_is": self}

    @abstractmethod
    def describe(self, scenario: str) -> str:
        """A scenario in words, as LeRobot's `task`."""

    @abstractmethod
    def environment(self, scenario: str) -> Environment:
        """A new environment; `close` it."""


def load_task(name: str) -> type[Task]:
    """The task of this name: one of TASKS, or "module:class"; ValueError where there is none."""
    found: type[Task] = find_subclass("task", name, TASKS, Task)
    return found
