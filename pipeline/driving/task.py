"""The paper's task: a car on a road, asked to keep its lane, to overtake and to brake."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from pipeline.data.schema import Feature
from pipeline.driving.features import FEATURES, ROBOT_TYPE, check_action_repeat
from pipeline.driving.metrics import FAILURES, METRICS
from pipeline.metric import Metric
from pipeline.settings import Setting, listed
from pipeline.task import Task

if TYPE_CHECKING:
    from pipeline.environment import Environment


@dataclass(frozen=True, kw_only=True)
class Driving(Task):
    """Where and among how many cars is driven, and for how long.

    Raises:
        ValueError: unknown track, no room on it for so much traffic, or a number out of its range.
    """

    name: ClassVar[str] = "driving"
    robot: ClassVar[str] = ROBOT_TYPE
    features: ClassVar[Mapping[str, Feature]] = FEATURES
    measure: ClassVar[str] = "steering"
    metrics: ClassVar[Mapping[str, Metric]] = METRICS
    failures: ClassVar[Mapping[str, str]] = FAILURES

    tracks: Annotated[
        str,
        Setting(
            "Names of tracks, separated by commas; random:7 is one too, and random:7-9 are three."
        ),
    ] = "alder,birch,cedar,hazel,larch,maple,rowan"
    traffic: Annotated[int, Setting("Other cars on the track.", 0)] = 20
    offset_spread: Annotated[
        float, Setting("Standard deviation of the initial offset from the lane [m].", 0)
    ] = 0.0
    angle_spread: Annotated[
        float, Setting("Standard deviation of the initial angle to the lane [rad].", 0)
    ] = 0.0
    begins: Annotated[
        Literal["anywhere", "line"],
        Setting("Where a drive begins: on the start line, or anywhere."),
    ] = "anywhere"
    action_repeat: Annotated[
        int, Setting("Control steps (1/30 s) in a frame: an action is held for them.", 1)
    ] = 3
    seconds: Annotated[float, Setting("Longest time of one drive [s].", above=0)] = 20.0
    laps: Annotated[float, Setting("Most laps of one drive.", above=0, finite=False)] = np.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        # what knows tracks takes a while to import, and `--help` need not wait for it
        from pipeline.driving.tracks import make_track
        from pipeline.driving.traffic import check_room

        for track in self.scenarios:
            check_room(make_track(track), self.traffic)
        check_action_repeat(self.action_repeat)

    @property
    def fps(self) -> int:
        """Frames per second."""
        return check_action_repeat(self.action_repeat)

    @property
    def scenarios(self) -> list[str]:
        """The tracks."""
        return [name for track in listed(self.tracks) for name in _each(track)]

    @property
    def conditions(self) -> Mapping[str, Task]:
        """Without traffic, and with it."""
        return {"no_traffic": replace(self, traffic=0), "traffic": self}

    def describe(self, scenario: str) -> str:
        """The track and its traffic."""
        return f"drive on {scenario} with {self.traffic} other cars"

    def environment(self, scenario: str) -> Environment:
        """The track, with a new start at each `reset`."""
        from pipeline.driving.environment import DrivingEnv

        return DrivingEnv(
            track=scenario,
            traffic=self.traffic,
            spread=(self.offset_spread, self.angle_spread),
            begins=self.begins,
            action_repeat=self.action_repeat,
            laps=self.laps,
            seconds=self.seconds,
        )


def _each(track: str) -> list[str]:
    """The tracks from the first to the last number of "random:7-9"; of others, the track itself."""
    family, _, numbers = track.partition(":")
    first, _, last = numbers.partition("-")
    if not (first.isdecimal() and last.isdecimal()):
        return [track]
    return [f"{family}:{number}" for number in range(int(first), int(last) + 1)] or [track]
