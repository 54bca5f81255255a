"""A drive as a Rerun recording: what the car saw, what each policy wanted, who drove, and why."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from pipeline.driving.features import AFFORDANCES
from pipeline.driving.tracks import Track
from pipeline.inspection.excerpts import Excerpt
from pipeline.inspection.footage import Footage, track_of
from pipeline.inspection.pairs import Pair
from pipeline.inspection.rerun_top_view import log_track, top_view
from pipeline.inspection.rerun_traces import COMPRESSED, Trace, dots, lane, level, line, tracer
from pipeline.rollout.judgement import Judgement

APPLICATION = "safedagger"
BLUE, LIGHT_BLUE, RED, ORANGE = 0x0072B2FF, 0x56B4E9FF, 0xD55E00FF, 0xE69F00FF
GREEN, PINK, GREY = 0x009E73FF, 0xCC79A7FF, 0x999999FF
SIDES = (BLUE, RED), (LIGHT_BLUE, ORANGE)  # where the primary drives, and the reference

Connect = Callable[[rr.RecordingStream], None]
"""Connects a new stream to the place where its recording shall go."""

Side = tuple[Footage, Judgement | None]
"""A drive, and by what its frames are judged."""


def log_excerpt(excerpt: Excerpt, connect: Connect, *, fps: int) -> None:
    """Send an excerpt as one recording; `connect` is called once, before anything is sent. ValueError
    where the episode's task names no track.
    """
    footage = Footage.of_episode(excerpt.episode, excerpt.first_frame, excerpt.judgement)
    track = track_of(excerpt.episode.task)
    with new_recording(excerpt.name, excerpt.title, track, connect) as recording:
        drive_tracer(recording, fps=fps, judgement=excerpt.judgement)(footage)


def log_pair(pair: Pair, connect: Connect, *, fps: int) -> None:
    """Send two episodes of one track as one recording; else as `log_excerpt`, and see `log_two_drives`."""
    a, b = (
        (Footage.of_episode(each.episode, each.first_frame, each.judgement), each.judgement)
        for each in (pair.a, pair.b)
    )
    track = track_of(pair.a.episode.task)
    log_two_drives(pair.name, pair.title, track, (a, b), connect, fps=fps)


def log_two_drives(
    name: str, title: str, track: Track, drives: tuple[Side, Side], connect: Connect, *, fps: int
) -> None:
    """Send two drives on one track as one recording, under a/ and b/."""
    with new_recording(name, title, track, connect) as recording:
        for root, drive, colors in zip(("a/", "b/"), drives, SIDES, strict=True):
            footage, judgement = drive
            send = drive_tracer(recording, fps=fps, judgement=judgement, root=root, colors=colors)
            send(footage)


@contextmanager
def new_recording(
    name: str, title: str, track: Track | None, connect: Connect
) -> Iterator[rr.RecordingStream]:
    """A recording with this id and title that already shows its track, if it was on one; complete
    when the block ends. `connect` is called once, before anything is sent.
    """
    with rr.RecordingStream(APPLICATION, recording_id=name) as recording:
        connect(recording)
        recording.send_recording_name(title)
        if track is not None:
            log_track(recording, track)
        yield recording
    recording.disconnect()


def drive_tracer(
    recording: rr.RecordingStream,
    *,
    fps: int,
    judgement: Judgement | None,
    root: str = "",
    colors: tuple[int, int] = (BLUE, RED),
    camera: Trace = COMPRESSED,
) -> Callable[[Footage], None]:
    """What sends all that is shown of a drive; for `recording` and `root` see `tracer`.

    The judgement's cut is drawn with the safe probability, its tau with the deviation; None where there
    is no safety policy. In the top view the `colors` are of the primary's and of the reference's driving.
    `camera` is one of COMPRESSED and RAW.
    """
    traces = [
        camera,
        *top_view(primary=colors[0], reference=colors[1], label=root.rstrip("/") or None),
        *_lanes(),
        *_judged(judgement),
        # the primary's wish where it had one, and the reference's where it is known
        line("action/primary_steering", BLUE, lambda frames: frames.primary_action[:, 0]),
        dots("action/reference_steering", RED, lambda frames: frames.reference_action[:, 0]),
        line("action/primary_brake", LIGHT_BLUE, lambda frames: frames.primary_action[:, 1]),
        dots("action/reference_brake", ORANGE, lambda frames: frames.reference_action[:, 1]),
        line("safe_probability/safe_probability", GREEN, lambda frames: frames.safe_probability),
        dots(  # a row, low in the plot
            "safe_probability/reference_drives",
            RED,
            lambda frames: np.where(frames.intervention, 0.03, np.nan),
        ),
        line("speed/speed", GREEN, lambda frames: frames.vehicle_state[:, 3]),
        line("in_lane/lane_position", BLUE, _affordance("lane_position")),
        line("in_lane/lane_angle", RED, _affordance("lane_angle")),
        line("distance/distance_left", BLUE, _affordance("distance_left")),
        line("distance/distance_ahead", RED, _affordance("distance_ahead")),
        line("distance/distance_right", GREEN, _affordance("distance_right")),
    ]
    return tracer(recording, traces, fps=fps, root=root)


def _judged(judgement: Judgement | None) -> list[Trace]:
    """The deviation; and where a safety policy drove, what it calls unsafe."""
    measure = judgement.words if judgement else "steering"
    plotted = dots(
        "deviation/deviation",
        PINK,
        lambda frames: frames.deviation,
        label=f"deviation of {measure}",
    )
    if judgement is None:
        return [plotted]
    tau = judgement.tau

    def deviates(frames: Footage) -> NDArray[np.str_]:
        known = np.where(frames.deviation > tau, "above tau", "up to tau")
        return np.where(np.isnan(frames.deviation), "", known)

    return [
        plotted,
        level("deviation/tau", GREY, tau),
        level("safe_probability/cut", GREY, judgement.cut),
        lane("who/deviation", {"up to tau": GREEN, "above tau": PINK}, deviates),
    ]


def _lanes() -> list[Trace]:
    """Who drove, who was asked, and what is there."""

    def flag(name: str) -> Trace:
        value = _affordance(name)
        return lane(
            f"around/{name}",
            {"yes": GREEN},
            lambda frames: np.where(value(frames) > 0.5, "yes", ""),
        )

    return [
        lane(
            "who/drove",
            {"primary": BLUE, "reference": RED},
            lambda frames: np.where(frames.intervention, "reference", "primary"),
        ),
        lane(
            "who/was_asked",
            {"reference": ORANGE},
            lambda frames: np.where(frames.queried, "reference", ""),
        ),
        *map(flag, AFFORDANCES[:5]),
    ]


def _affordance(name: str) -> Callable[[Footage], NDArray[np.float32]]:
    column = AFFORDANCES.index(name)
    return lambda frames: frames.affordances[:, column]
