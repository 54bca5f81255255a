"""Drives as episodes of a dataset. In the shapes, T is the number of frames."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.data.schema import OWN, Asked, Episode
from pipeline.policies.measures import deviation, half_range
from pipeline.rollout.loop import Frame
from pipeline.rollout.plans import Plan, driven
from pipeline.rollout.rules.rule import Rule
from pipeline.rollout.workers import in_order
from pipeline.task import Task

if TYPE_CHECKING:
    from pipeline.policies.inference import Driver

BUDGET = "budget spent"
"""Why a drive ended that would have gone on: there was nothing left to ask or to drive."""


@dataclass(frozen=True)
class Recording:
    """A drive that has been driven."""

    episode: Episode
    reference_actions: NDArray[np.float32]
    """[T, A] what the reference would have done, also where it was not asked, if it was looked up:
    to measure with, never to train or to select on"""
    outcomes: list[dict[str, float]]
    """T, what the drive had come to at the end of each frame"""

    @property
    def queries(self) -> int:
        """How often the reference was asked."""
        return int(self.episode.columns["queried"].sum())

    @property
    def ended(self) -> str:
        """Why the drive was over, in words."""
        return str((self.episode.ending or {})["ended"])

    def until(self, stop: int) -> Recording:
        """Its first `stop` frames, at least one: if these are not all, the budget ended it."""
        if stop == len(self.episode):
            return self
        part = self.episode.rows(0, stop)
        number = int(part.columns["source.episode"][0, 0])
        ending = _ending(number, part.task, stop, self.outcomes[stop - 1], BUDGET, failed=False)
        return Recording(
            replace(part, ending=ending), self.reference_actions[:stop], self.outcomes[:stop]
        )


def record(
    plan: Plan, driver: Driver | None, iteration: int, number: int, measure: bool = True
) -> Recording:
    """Drive once and keep every frame; `number` is the drive's in its iteration, for provenance."""
    frames = [frame for _, frame in driven(plan, driver, measure=measure)]
    last = frames[-1]
    ended = last.ended or ""
    return Recording(
        Episode(
            plan.description,
            _columns(plan.task, frames, iteration, number),
            plan.task.features,
            _ending(number, plan.description, len(frames), last.outcome, ended, failed=last.failed),
        ),
        np.stack([frame.reference_action for frame in frames]),
        [dict(frame.outcome) for frame in frames],
    )


def record_all(
    task: Task,
    rule: Rule,
    driver: Driver | None,
    numbers: Iterable[int],
    *,
    seed: tuple[int, ...],
    iteration: int,
    workers: int | None,
    measure: bool = True,
) -> Generator[Recording]:
    """Record one drive after the other, around the scenarios of a task, in the order of `numbers`.

    Drive n is in scenario n modulo their number, with n appended to the seed. Whoever has enough
    closes it: drives have been begun that nobody will see. ValueError, before anything is driven, where
    the task does not show what the primary sees.
    """
    if driver is not None:
        driver.check_task(task.name, task.features)
    names = task.scenarios
    jobs = (
        (Plan(task, names[n % len(names)], rule, (*seed, n)), driver, iteration, n, measure)
        for n in numbers
    )
    return in_order(record, jobs, workers)


def until_queries(
    recordings: Iterable[Recording], queries: int, frames: int
) -> Iterator[Recording]:
    """Recordings until the reference was asked `queries` times or `frames` were driven; the last
    one is cut short.
    """
    asked = driven_ = 0
    for recording in recordings:
        paid = asked + np.cumsum(recording.episode.columns["queried"][:, 0])
        stop = min(int(np.searchsorted(paid, queries)) + 1, frames - driven_, len(paid))
        yield recording.until(stop)
        asked, driven_ = int(paid[stop - 1]), driven_ + stop
        if asked >= queries or driven_ >= frames:
            return


def _ending(
    number: int,
    task: str,
    frames: int,
    outcome: Any,
    ended: str,
    *,
    failed: bool,
) -> dict[str, Any]:
    """A row of the drives of a dataset."""
    told = {name: round(float(value), 3) for name, value in outcome.items()}
    return {
        "episode": number,
        "task": task,
        "frames": frames,
        **told,
        "ended": ended,
        "put_back": int(failed),
    }


def _columns(
    task: Task, frames: list[Frame], iteration: int, number: int
) -> dict[str, NDArray[Any]]:
    """All of the task's features."""

    def each(values: Iterable[Any], dtype: type) -> NDArray[Any]:
        return np.array([[value] for value in values], dtype)

    def stacked(part: str) -> dict[str, NDArray[Any]]:
        names = getattr(frames[0], part)
        return {name: np.stack([getattr(frame, part)[name] for frame in frames]) for name in names}

    because = each((frame.decision.asked for frame in frames), np.int64)
    queried = because != Asked.NOT
    reference = np.stack([frame.reference_action for frame in frames])
    primary = np.stack([frame.primary_action for frame in frames])
    half_ranges = half_range(task.features["action"])
    epsilon = deviation(task.measure, primary, reference, half_ranges)[:, None]
    return {
        **stacked("observation"),
        **stacked("hidden"),
        "action": np.where(queried, reference, primary),
        "primary_action": primary,
        "intervention": each((frame.intervention for frame in frames), np.bool_),
        "queried": queried,
        "safe_probability": each((frame.safe_probability for frame in frames), np.float32),
        "deviation": np.where(queried, epsilon, np.nan).astype(np.float32),
        "asked_because": because,
        "ask_probability": each((f.decision.ask_probability for f in frames), np.float32),
        "source.dataset": np.full((len(frames), 1), OWN, np.int64),
        "source.iteration": np.full((len(frames), 1), iteration, np.int64),
        "source.episode": np.full((len(frames), 1), number, np.int64),
        "source.frame": np.arange(len(frames), dtype=np.int64)[:, None],
    }
