"""Frames of a drive as they are shown, whether a dataset has them or they are being driven."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Episode
from pipeline.driving.cars import LENGTH
from pipeline.driving.deviation import steering
from pipeline.driving.features import CAMERA, FEATURES, ROBOT_TYPE
from pipeline.driving.tracks import LANE_WIDTH, Track, make_track
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.loop import Frame

TASK = re.compile(r"drive on (\S+) with \d+ other cars")  # as `Driving.describe` says it
BESIDE = np.array([LANE_WIDTH, 0.0, -LANE_WIDTH])  # [m] to the left, same and right lane


@dataclass(frozen=True, eq=False)
class Footage:
    """Successive frames of one drive. T frames."""

    frame: NDArray[np.int64]
    """[T] numbers within the drive"""
    image: NDArray[np.uint8]
    """[T, 72, 160, 3]"""
    primary_action: NDArray[np.float32]
    """[T, 2] NaN where the primary was not asked"""
    reference_action: NDArray[np.float32]
    """[T, 2] NaN where it is not known"""
    intervention: NDArray[np.bool_]
    """[T] the reference drove"""
    queried: NDArray[np.bool_]
    """[T] the reference was asked"""
    safe_probability: NDArray[np.float32]
    """[T] NaN where there is none"""
    deviation: NDArray[np.float32]
    """[T] NaN where it is not known; of the brake too where the labels of the safety policy are"""
    affordances: NDArray[np.float32]
    """[T, 10]"""
    vehicle_state: NDArray[np.float32]
    """[T, 4] x, y [m], heading [rad] and speed [m/s]"""
    end: NDArray[np.float32]
    """[T, 2] (m) where our car was when the frame was over"""
    others: list[NDArray[np.float64]]
    """T times [M, 3]: x, y [m] and heading [rad] of the other cars, as many as are known"""

    def __len__(self) -> int:
        return len(self.frame)

    def rows(self, start: int, stop: int) -> "Footage":
        """Frames `start` (inclusive) to `stop` (exclusive), counted from the first one here."""
        return Footage(**{each.name: getattr(self, each.name)[start:stop] for each in fields(self)})

    @classmethod
    def joined(cls, parts: Sequence["Footage"]) -> Self:
        """One after the other, at least one."""
        arrays = {
            each.name: np.concatenate([getattr(part, each.name) for part in parts])
            for each in fields(cls)
            if each.name != "others"
        }
        return cls(**arrays, others=[cars for part in parts for cars in part.others])

    @classmethod
    def of_episode(
        cls, episode: Episode, first_frame: int = 0, judgement: Judgement | None = None
    ) -> Self:
        """What a dataset tells of an episode, or a part of one whose first row has this number: other
        cars only where one of the affordances is about them; deviations by the judgement, of the
        steering without one. Raises as `track_of`.
        """
        rows = episode.columns
        state = rows["vehicle_state"]
        reference = np.where(rows["queried"], rows["action"], np.float32(np.nan))
        epsilon = rows["deviation"][:, 0]
        if judgement is not None:
            epsilon = judgement.deviation(rows["primary_action"], reference)
        return cls(
            frame=first_frame + np.arange(len(episode)),
            image=rows[CAMERA],
            primary_action=rows["primary_action"],
            reference_action=reference,
            intervention=rows["intervention"][:, 0],
            queried=rows["queried"][:, 0],
            safe_probability=rows["safe_probability"][:, 0],
            deviation=epsilon.astype(np.float32),
            affordances=rows["affordances"],
            vehicle_state=state,
            end=np.concatenate([state[1:, :2], state[-1:, :2]]),
            others=cars_in_affordances(track_of(episode.task), state, rows["affordances"]),
        )

    @classmethod
    def of_frame(
        cls,
        number: int,
        frame: Frame,
        end: NDArray[np.float32],
        others: NDArray[np.float64],
        judgement: Judgement | None = None,
    ) -> Self:
        """One frame just driven, the `number`th of its drive, with all that the simulator knows: our car
        is now at `end` [2] (m); the `others` were at x, y [m] and heading [rad], [M, 3], when it
        began. For `judgement` see `of_episode`.
        """
        driven = np.array([frame.intervention])
        pair = frame.primary_action[None], frame.reference_action[None]
        epsilon = judgement.deviation(*pair) if judgement else steering(*pair)
        return cls(
            frame=np.array([number]),
            image=frame.observation[CAMERA][None],
            primary_action=frame.primary_action[None],
            reference_action=frame.reference_action[None],
            intervention=driven,
            queried=driven,
            safe_probability=np.array([frame.safe_probability], np.float32),
            deviation=epsilon.astype(np.float32),
            affordances=frame.hidden["affordances"][None],
            vehicle_state=frame.hidden["vehicle_state"][None],
            end=end[None],
            others=[others],
        )


def is_of_the_car(dataset: Dataset) -> bool:
    """Whether a dataset is of the driving world; ValueError where it says so, and lacks a column of it."""
    if dataset.info["robot_type"] != ROBOT_TYPE:
        return False
    dataset.require(FEATURES)
    return True


def track_of(task: str) -> Track:
    """The track that an episode's task names; ValueError where it names none, or one that there is not."""
    named = TASK.fullmatch(task)
    if named is None:
        raise ValueError(f"task {task!r}: expected 'drive on <track> with <n> other cars'")
    return make_track(named[1])


def cars_in_affordances(
    track: Track, state: NDArray[np.float32], affordances: NDArray[np.float32]
) -> list[NDArray[np.float64]]:
    """The cars ahead in the left, same and right lane, as `Footage.others`, from our own state [T, 4] and
    our affordances [T, 10]: how far along the road is known, and where in its lane a car drives is
    not: it is taken to be in the middle.
    """
    line = track.centreline
    x, y = state[:, :2].astype(np.float64).T
    nearest = KDTree(np.stack([line.x, line.y], axis=1)).query(np.stack([x, y], axis=1))[1]
    s, d = line.local_coordinates(x, y, nearest * line.length / len(line.x))
    there = affordances[:, 2:5] > 0.5
    along = s[:, None] + affordances[:, 5:8].astype(np.float64) + LENGTH
    lateral = track.lane_centres[track.lane_of(d)][:, None] + BESIDE
    cars = np.stack([*line.position(along, lateral), line.heading_at(along)], axis=2)
    return [car[seen] for car, seen in zip(cars, there, strict=True)]
