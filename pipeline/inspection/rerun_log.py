"""An excerpt as a Rerun recording: what the car saw, what each policy wanted, who drove, and why.

There is no top view: no column says where along the track the car is. In the shapes, T is the
number of rows of the excerpt.
"""

from collections.abc import Callable

import cv2
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from pipeline.data.schema import AFFORDANCES, CAMERA
from pipeline.inspection.excerpts import Excerpt

APPLICATION = "safedagger"
IMAGES_AT_ONCE = 64
BLUE, LIGHT_BLUE, RED, ORANGE = 0x0072B2FF, 0x56B4E9FF, 0xD55E00FF, 0xE69F00FF
GREEN, PINK, GREY = 0x009E73FF, 0xCC79A7FF, 0x999999FF
FLAGS, DISTANCES, IN_LANE = AFFORDANCES[:5], AFFORDANCES[5:8], AFFORDANCES[8:]

Connect = Callable[[rr.RecordingStream], None]
"""Connects a new stream to the place where its recording shall go."""


def log_excerpt(excerpt: Excerpt, connect: Connect, *, fps: int, cut: float, tau: float) -> None:
    """Send an excerpt as one recording.

    Args:
        excerpt: what to send.
        connect: is called once, before anything is sent.
        fps: frames per second.
        cut: drawn with the safe probability: a frame below it is unsafe.
        tau: drawn with the deviation: a frame above it is unsafe.
    """
    with rr.RecordingStream(APPLICATION, recording_id=excerpt.name) as recording:
        connect(recording)
        recording.send_recording_name(excerpt.title)
        log = _Log(recording, excerpt.first_frame + np.arange(len(excerpt)), fps)
        _log_lanes(log, excerpt.episode.columns, tau)
        _log_actions(log, excerpt.episode.columns)
        _log_safety(log, excerpt.episode.columns, cut, tau)
        _log_affordances(log, excerpt.episode.columns)
        log.images("camera", excerpt.episode.columns[CAMERA])
    recording.disconnect()


def blueprint(fps: int) -> rrb.Blueprint:
    """Where the viewer shows what."""
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial2DView(origin="camera", name="camera"),
                rrb.StateTimelineView(origin="who", name="who drove, and was there reason to"),
                rrb.StateTimelineView(origin="around", name="what is there"),
                row_shares=[8, 5, 7],
            ),
            rrb.Vertical(
                _plot("action", "steering and brake"),
                _plot("safe_probability", "safe probability", axis=(0.0, 1.0)),
                _plot("deviation", "deviation"),
                _plot("in_lane", "position in the lane and angle to it"),
                _plot("distance", "distances [m]"),
            ),
            column_shares=[2, 3],
        ),
        rrb.TimePanel(timeline="frame_index", state="collapsed", fps=fps),
        rrb.BlueprintPanel(state="expanded"),  # lists the recordings
        rrb.SelectionPanel(state="hidden"),
    )


def _plot(origin: str, name: str, axis: tuple[float, float] | None = None) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_y=None if axis is None else rrb.ScalarAxis(range=axis),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
    )


class _Log:
    """A recording, and the times of its T rows on both timelines."""

    def __init__(self, recording: rr.RecordingStream, frame: NDArray[np.int64], fps: int) -> None:
        self._recording = recording
        self._frame = frame
        self._fps = fps

    def line(self, entity: str, values: NDArray, color: int, *, width: float = 1.5) -> None:
        """Plot `values`, [T], known in most rows, else NaN."""
        look = rr.SeriesLines(names=_label(entity), colors=color, widths=width)
        self._plot(entity, values, look)

    def dots(self, entity: str, values: NDArray, color: int) -> None:
        """Plot `values`, [T], known in some rows, else NaN: a line would not show a single one."""
        look = rr.SeriesPoints(names=_label(entity), colors=color, marker_sizes=2.0)
        self._plot(entity, values, look)

    def lane(self, entity: str, states: NDArray[np.str_], **colors: int) -> None:
        """A coloured lane of `states`, [T]; the empty state is a gap."""
        look = rr.StateConfiguration(values=list(colors), colors=list(colors.values()))
        self._recording.log(entity, look, static=True)
        self._send(entity, slice(None), rr.StateChange.columns(state=states.tolist()))

    def images(self, entity: str, images: NDArray[np.uint8]) -> None:
        """Lossless pictures of `images`, [T, H, W, 3] (RGB)."""
        for start in range(0, len(images), IMAGES_AT_ONCE):
            some = slice(start, start + IMAGES_AT_ONCE)
            pngs = [_png(image) for image in images[some]]
            columns = rr.EncodedImage.columns(blob=pngs, media_type=["image/png"] * len(pngs))
            self._send(entity, some, columns)

    def _plot(self, entity: str, values: NDArray, look: rr.SeriesLines | rr.SeriesPoints) -> None:
        self._recording.log(entity, look, static=True)
        self._send(entity, slice(None), rr.Scalars.columns(scalars=values))

    def _send(self, entity: str, rows: slice, columns: rr.ComponentColumnList) -> None:
        frame = self._frame[rows]
        times = [
            rr.TimeColumn("frame_index", sequence=frame),
            rr.TimeColumn("timestamp", duration=frame / self._fps),
        ]
        self._recording.send_columns(entity, times, columns)


def _log_lanes(log: _Log, rows: dict[str, NDArray], tau: float) -> None:
    """Who drove, who was asked, and where that is known, whether there was reason to."""
    drove, queried = rows["intervention"][:, 0], rows["queried"][:, 0]
    deviation = rows["deviation"][:, 0]
    known = np.where(deviation > tau, "above tau", "up to tau")
    log.lane("who/drove", np.where(drove, "reference", "primary"), primary=BLUE, reference=RED)
    log.lane("who/was_asked", np.where(queried, "reference", ""), reference=ORANGE)
    deviates = np.where(np.isnan(deviation), "", known)
    log.lane("who/deviation", deviates, **{"up to tau": GREEN, "above tau": PINK})


def _log_actions(log: _Log, rows: dict[str, NDArray]) -> None:
    """The primary's wish where it had one, and the reference's where it was asked for it."""
    primary = rows["primary_action"]
    reference = np.where(rows["queried"], rows["action"], np.float32(np.nan))
    log.line("action/primary_steering", primary[:, 0], BLUE)
    log.dots("action/reference_steering", reference[:, 0], RED)
    log.line("action/primary_brake", primary[:, 1], LIGHT_BLUE)
    log.dots("action/reference_brake", reference[:, 1], ORANGE)


def _log_safety(log: _Log, rows: dict[str, NDArray], cut: float, tau: float) -> None:
    length = len(rows["queried"])
    log.line("safe_probability/safe_probability", rows["safe_probability"][:, 0], GREEN)
    log.line("safe_probability/cut", np.full(length, cut), GREY, width=1.0)
    log.dots("deviation/deviation", rows["deviation"][:, 0], PINK)
    log.line("deviation/tau", np.full(length, tau), GREY, width=1.0)


def _log_affordances(log: _Log, rows: dict[str, NDArray]) -> None:
    affordances = dict(zip(AFFORDANCES, rows["affordances"].T, strict=True))
    for name in FLAGS:
        log.lane(f"around/{name}", np.where(affordances[name] > 0.5, "yes", ""), yes=GREEN)
    for name, color in zip(IN_LANE, (BLUE, RED), strict=True):
        log.line(f"in_lane/{name}", affordances[name], color)
    for name, color in zip(DISTANCES, (BLUE, RED, GREEN), strict=True):
        log.line(f"distance/{name}", affordances[name], color)


def _label(entity: str) -> str:
    return entity.rsplit("/")[-1].replace("_", " ")


def _png(image: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()
