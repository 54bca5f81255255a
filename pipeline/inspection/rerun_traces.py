"""Traces: what Rerun shows of each frame of a drive, each under a name of its own, with its look."""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from pipeline.driving.features import IMAGE_SHAPE
from pipeline.inspection.footage import Footage

ALL, PICTURES = sys.maxsize, 64


@dataclass(frozen=True)
class Trace:
    """One entity of a recording."""

    entity: str
    look: rr.AsComponents | None
    """What is the same in all frames: names, colours, widths."""
    columns: Callable[[Footage], rr.ComponentColumnList]
    """What differs: a row for each frame."""
    at_once: int = ALL
    """Frames at a time, to bound memory. All for lanes: the viewer shows them as far as it gets at
    first (rerun-io/rerun#12763)."""


def tracer(
    recording: rr.RecordingStream, traces: list[Trace], *, fps: int, root: str = ""
) -> Callable[[Footage], None]:
    """What sends the next frames of a drive, one or many, to a connected recording, on the timelines
    `frame_index` and `timestamp`; `root` is in front of every entity, where a recording has several
    drives: "a/", say.
    """
    for trace in traces:
        if trace.look is not None:
            recording.log(root + trace.entity, trace.look, static=True)

    def send(footage: Footage) -> None:
        for trace in traces:
            for start in range(0, len(footage), trace.at_once):
                some = footage.rows(start, min(start + trace.at_once, len(footage)))
                times = [
                    rr.TimeColumn("frame_index", sequence=some.frame),
                    rr.TimeColumn("timestamp", duration=some.frame / fps),
                ]
                recording.send_columns(root + trace.entity, times, trace.columns(some))

    return send


def line(
    entity: str, color: int, values: Callable[[Footage], NDArray], *, width: float = 1.5
) -> Trace:
    """A plot of `values`, [T], that are known in most frames, else NaN."""
    return _plot(entity, rr.SeriesLines(names=_label(entity), colors=color, widths=width), values)


def dots(
    entity: str, color: int, values: Callable[[Footage], NDArray], *, label: str | None = None
) -> Trace:
    """A plot of `values`, [T], known in some frames, else NaN: a line would not show a single one."""
    look = rr.SeriesPoints(names=label or _label(entity), colors=color, marker_sizes=2.0)
    return _plot(entity, look, values)


def level(entity: str, color: int, value: float) -> Trace:
    """A thin line at `value` in a plot."""
    return line(entity, color, lambda footage: np.full(len(footage), value), width=1.0)


def lane(entity: str, colors: dict[str, int], states: Callable[[Footage], NDArray]) -> Trace:
    """A lane of `states`, [T], in their `colors`; the empty state is a gap."""
    return Trace(
        entity,
        rr.StateConfiguration(values=list(colors), colors=list(colors.values())),
        lambda footage: rr.StateChange.columns(state=states(footage).tolist()),
    )


def _plot(entity: str, look: rr.AsComponents, values: Callable[[Footage], NDArray]) -> Trace:
    return Trace(entity, look, lambda footage: rr.Scalars.columns(scalars=values(footage)))


def _label(entity: str) -> str:
    return entity.rsplit("/")[-1].replace("_", " ")


def _pngs(footage: Footage) -> rr.ComponentColumnList:
    pngs = [_png(image) for image in footage.image]
    return rr.EncodedImage.columns(blob=pngs, media_type=["image/png"] * len(pngs))


def _png(image: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def _buffers(footage: Footage) -> rr.ComponentColumnList:
    return rr.Image.columns(buffer=[image.tobytes() for image in footage.image])


_FORMAT = rr.components.ImageFormat(
    width=IMAGE_SHAPE[1], height=IMAGE_SHAPE[0], color_model="RGB", channel_datatype="U8"
)
COMPRESSED = Trace("camera", None, _pngs, PICTURES)
"""The camera's pictures, as PNG."""
RAW = Trace("camera", rr.Image.from_fields(format=_FORMAT), _buffers, PICTURES)
"""Twice as large: for a live view, which would wait for each PNG to be read and show none."""
