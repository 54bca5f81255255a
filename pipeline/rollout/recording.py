"""Drives as episodes of a dataset."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError
from numpy.typing import NDArray

from pipeline.data.schema import OWN, Asked, Episode
from pipeline.driving.features import CAMERA, FEATURES, check_record_every
from pipeline.driving.tracks import make_track
from pipeline.driving.traffic import check_room
from pipeline.driving.world import World
from pipeline.policies.inference import Driver
from pipeline.rollout.loop import Ended, Frame, drive
from pipeline.rollout.strategies import Rule, Strategy

SEED_STREAMS = {
    "D_0": 0,
    "D_safe": 1,
    "D_held": 2,
    "supervised": 10,
    "rollout": 100,
    "evaluation": 1000,
    "film": 2000,
}
"""The second number of every drive's seed: no two collections of an experiment meet the same random
numbers.
"""


@dataclass(frozen=True)
class Drive:
    """What is to be driven, and how. Every drive has a random generator of its own, so their order
    does not matter.

    Raises:
        ValueError: unknown track, no room on it for so much traffic, or a number out of its range.
    """

    track: str
    """a name that `make_track` knows"""
    traffic: int
    """other cars, >= 0"""
    spread: tuple[float, float]
    """standard deviations of the initial lateral offset [m] and angle [rad]: the paper's S_0"""
    seed: tuple[int, ...]
    """of the drive's random generator"""
    rule: Rule
    """who drives"""
    record_every: int
    """control steps in a frame, >= 1"""
    seconds: float
    """the longest it may take, > 0"""
    laps: float = np.inf
    """the farthest it may go, > 0"""

    def __post_init__(self) -> None:
        check_room(make_track(self.track), self.traffic)
        check_record_every(self.record_every)
        if not 0 < self.seconds < np.inf:
            raise ValueError(f"seconds is {self.seconds}, expected a number above 0")
        if not self.laps > 0:
            raise ValueError(f"laps is {self.laps}, expected a number above 0")
        for spread in self.spread:
            if not 0 <= spread < np.inf:
                raise ValueError(f"spread is {spread}, expected a number of at least 0")

    @property
    def task(self) -> str:
        """The scenario in words, as datasets carry it."""
        return f"drive on {self.track} with {self.traffic} other cars"


@dataclass(frozen=True)
class Recording:
    """A drive that has been driven. T frames."""

    episode: Episode
    reference_actions: NDArray[np.float32]
    """[T, 2] what the reference would have done, also where it was not asked: to measure with,
    never to train or to select on"""
    distance: NDArray[np.float64]
    """[T] (m) driven along the road at the end of each frame"""
    touches: NDArray[np.int64]
    """[T] of other cars until then"""

    @property
    def queries(self) -> int:
        """How often the reference was asked."""
        return int(self.episode.columns["queried"].sum())

    def until(self, stop: int) -> Recording:
        """Its first `stop` frames, at least one: if these are not all, the budget ended it."""
        if stop == len(self.episode):
            return self
        distance, touches = self.distance[:stop], self.touches[:stop]
        part = self.episode.rows(0, stop)
        number = int(part.columns["source.episode"][0, 0])
        ending = _ending(number, part.task, Ended.BUDGET, distance, touches)
        part = replace(part, ending=ending)
        return Recording(part, self.reference_actions[:stop], distance, touches)


def driven(plan: Drive, driver: Driver | None) -> Iterator[tuple[World, Frame]]:
    """The frames of a drive, each with the world as it is at its end."""
    rng = np.random.default_rng(plan.seed)
    with World(make_track(plan.track), plan.traffic, plan.spread, rng) as world:
        for frame in drive(
            world,
            driver,
            plan.rule,
            record_every=plan.record_every,
            laps=plan.laps,
            seconds=plan.seconds,
            rng=rng,
        ):
            yield world, frame


def record(plan: Drive, driver: Driver | None, iteration: int, number: int) -> Recording:
    """Drive once and keep every frame; `number` is the drive's in its iteration, for provenance.

    The reference is asked for the frames that it drives, and under a mixture, which is DAgger's,
    for all of them.
    """
    frames = [frame for _, frame in driven(plan, driver)]
    labelled = plan.rule.strategy is Strategy.MIXTURE
    distance = np.array([frame.distance for frame in frames])
    touches = np.array([frame.touches for frame in frames])
    ended = frames[-1].ended
    assert ended is not None
    return Recording(
        Episode(
            plan.task,
            _columns(frames, iteration, number, every_frame=labelled),
            FEATURES,
            _ending(number, plan.task, ended, distance, touches),
        ),
        np.stack([frame.reference_action for frame in frames]),
        distance,
        touches,
    )


def record_all(
    plan: Drive,
    tracks: Sequence[str],
    numbers: Iterable[int],
    driver: Driver | None,
    *,
    iteration: int,
    workers: int,
) -> Iterator[Recording]:
    """Record one drive after the other, around the tracks, in the order of `numbers`.

    Drive n is `plan` on track n modulo their number, with n appended to its seed.

    Raises:
        ValueError: a track is unknown or has no room for the traffic; at once.
    """
    plans = [replace(plan, track=track) for track in tracks]
    jobs = (
        (replace(plans[n % len(plans)], seed=(*plan.seed, n)), driver, iteration, n)
        for n in numbers
    )
    return in_order(record, jobs, workers)


def in_order[Result](
    job: Callable[..., Result], arguments: Iterable[tuple], workers: int
) -> Iterator[Result]:
    """Run `job(*arguments)` in `workers` processes; the results come in the order of the arguments,
    as they are ready.

    Raises:
        OSError: the system killed one of them.
    """
    pool = Parallel(n_jobs=workers, return_as="generator", batch_size=1, pre_dispatch="2 * n_jobs")
    results = pool(delayed(_on_one_thread)(job, each) for each in arguments)
    try:
        for result in results:  # noqa: UP028 (the warning below is given when `results` is closed)
            yield result
    except TerminatedWorkerError:
        raise OSError(
            "a worker process was killed, maybe for want of memory: try fewer workers"
        ) from None
    finally:
        with warnings.catch_warnings():
            # Whoever has enough stops early: what was begun beyond that is meant to be lost.
            warnings.simplefilter("ignore", UserWarning)
            results.close()


def _on_one_thread[Result](job: Callable[..., Result], arguments: tuple) -> Result:
    """Another number of threads may round differently, and then so would another number of workers."""
    torch.set_num_threads(1)
    return job(*arguments)


def until_queries(
    recordings: Iterable[Recording], queries: int, frames: int
) -> Iterator[Recording]:
    """Recordings until the reference was asked `queries` times or `frames` were driven; the last
    one is cut short.
    """
    asked = driven = 0
    for recording in recordings:
        paid = asked + np.cumsum(recording.episode.columns["queried"][:, 0])
        stop = min(int(np.searchsorted(paid, queries)) + 1, frames - driven, len(paid))
        yield recording.until(stop)
        asked, driven = int(paid[stop - 1]), driven + stop
        if asked >= queries or driven >= frames:
            return


def _ending(
    number: int,
    task: str,
    ended: Ended,
    distance: NDArray[np.float64],
    touches: NDArray[np.int64],
) -> dict[str, str | int | float]:
    """A row of the drives of a dataset."""
    return {
        "episode": number,
        "task": task,
        "frames": len(distance),
        "distance_m": round(float(distance[-1]), 3),
        "touches": int(touches[-1]),
        "ended": str(ended),
        "put_back": int(ended.failed),
    }


def _columns(
    frames: list[Frame], iteration: int, number: int, *, every_frame: bool
) -> dict[str, NDArray]:
    """All of FEATURES."""
    intervention = np.array([[frame.intervention] for frame in frames])
    queried = intervention | every_frame
    reference = np.stack([frame.reference_action for frame in frames])
    primary = np.stack([frame.primary_action for frame in frames])
    errors = np.array([frame.squared_error for frame in frames])
    asked = np.where(intervention, Asked.DROVE, Asked.MIXTURE if every_frame else Asked.NOT)
    return {
        CAMERA: np.stack([frame.image for frame in frames]),
        "action": np.where(queried, reference, primary),
        "primary_action": primary,
        "affordances": np.stack([frame.affordances for frame in frames]),
        "vehicle_state": np.stack([frame.vehicle_state for frame in frames]),
        "intervention": intervention,
        "queried": queried,
        "safe_probability": np.array([[frame.safe_probability] for frame in frames], np.float32),
        "deviation": np.where(queried, errors[:, None], np.nan).astype(np.float32),
        "asked_because": asked.astype(np.int64),
        # every strategy decides for certain: of what it asks nothing is left to chance
        "ask_probability": queried.astype(np.float32),
        "source.dataset": np.full((len(frames), 1), OWN, np.int64),
        "source.iteration": np.full((len(frames), 1), iteration, np.int64),
        "source.episode": np.full((len(frames), 1), number, np.int64),
        "source.frame": np.arange(len(frames), dtype=np.int64)[:, None],
    }
