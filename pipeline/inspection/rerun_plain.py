"""A drive of any robot as a Rerun recording: what its cameras saw, what it did, who drove.

For datasets that know nothing of roads and lanes. T is the number of frames.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Feature
from pipeline.inspection.excerpts import Excerpt
from pipeline.inspection.pairs import Pair
from pipeline.inspection.rerun_log import BLUE, GREEN, ORANGE, RED, Connect, new_recording

QUALITY = 90  # of the JPEG: a camera of a robot is larger than the car's


def plain_blueprint(*datasets: Dataset) -> rrb.Blueprint:
    """Cameras above each other, and beside them who drove and what was done; for `log_plain` of one
    dataset, or of two for `log_plain_pair`.
    """
    roots = ("a/", "b/") if len(datasets) > 1 else ("",)
    return rrb.Blueprint(
        rrb.Horizontal(
            *(view for each in zip(datasets, roots, strict=True) for view in _seen_and_done(*each)),
            column_shares=[2, 3] * len(datasets),
        ),
        rrb.TimePanel(timeline="frame_index", state="collapsed", fps=datasets[0].fps),
        rrb.SelectionPanel(state="hidden"),
    )


def _seen_and_done(dataset: Dataset, root: str) -> tuple[rrb.Vertical, rrb.Vertical]:
    return (
        rrb.Vertical(
            *(
                rrb.Spatial2DView(origin=root + camera, name=root + camera)
                for camera in dataset.cameras
            )
        ),
        rrb.Vertical(
            rrb.StateTimelineView(origin=f"{root}who", name=f"{root}who drove, who was asked"),
            rrb.TimeSeriesView(origin=f"{root}safe_probability", name=f"{root}safe probability"),
            *(
                rrb.TimeSeriesView(origin=f"{root}action/{name}", name=f"{root}action: {name}")
                for name in action_names(dataset.features["action"])
            ),
        ),
    )


def log_plain(excerpt: Excerpt, connect: Connect, *, fps: int) -> None:
    """Send an excerpt as one recording; `connect` is called once, before anything is sent."""
    with new_recording(excerpt.name, excerpt.title, None, connect) as recording:
        _send(recording, excerpt, fps=fps, root="")


def log_plain_pair(pair: Pair, connect: Connect, *, fps: int) -> None:
    """Send two drives of one task as one recording, under a/ and b/; else as `log_plain`."""
    with new_recording(pair.name, pair.title, None, connect) as recording:
        _send(recording, pair.a, fps=fps, root="a/")
        _send(recording, pair.b, fps=fps, root="b/")


def _send(recording: rr.RecordingStream, excerpt: Excerpt, *, fps: int, root: str) -> None:
    """All that is shown of an excerpt, each entity's name behind `root`."""
    episode = excerpt.episode
    columns, features = episode.columns, episode.features
    numbers = np.arange(len(episode)) + excerpt.first_frame
    times = [
        rr.TimeColumn("frame_index", sequence=numbers),
        rr.TimeColumn("timestamp", duration=numbers / fps),
    ]

    def send(entity: str, look: rr.AsComponents, shown: rr.ComponentColumnList) -> None:
        recording.log(root + entity, look, static=True)
        recording.send_columns(root + entity, times, shown)

    for name in (n for n, of in features.items() if of["dtype"] in ("image", "video")):
        for number, image in zip(numbers, columns[name], strict=True):
            recording.set_time("frame_index", sequence=int(number))
            recording.set_time("timestamp", duration=float(number / fps))
            recording.log(root + name, rr.Image(image).compress(jpeg_quality=QUALITY))
    recording.reset_time()
    for entity, (color, values) in _lines(columns, features["action"]).items():
        look = rr.SeriesLines(names=entity.rsplit("/")[-1], colors=color)
        send(entity, look, rr.Scalars.columns(scalars=values))
    for entity, (words, color, flags) in {
        "who/drove": (("reference", "primary"), RED, columns["intervention"]),
        "who/was_asked": (("reference", ""), ORANGE, columns["queried"]),
    }.items():
        known = [word for word in words if word]
        states = rr.StateConfiguration(values=known, colors=[color, BLUE][: len(known)])
        said = np.where(flags[:, 0], *words).tolist()
        send(entity, states, rr.StateChange.columns(state=said))


def action_names(action: Feature) -> Sequence[str]:
    """Of its numbers; LeRobot has them as a list, as an object with a list, or not at all."""
    names = action.get("names")
    if isinstance(names, Mapping):
        names = next(iter(names.values()))
    return names or [str(number) for number in range(action["shape"][0])]


def _lines(columns: Mapping[str, np.ndarray], action: Feature) -> dict[str, tuple[int, np.ndarray]]:
    """By entity: its colour and its values [T]."""
    found = {"safe_probability/safe_probability": (GREEN, columns["safe_probability"][:, 0])}
    for number, name in enumerate(action_names(action)):
        found[f"action/{name}/action"] = RED, columns["action"][:, number]
        found[f"action/{name}/primary_action"] = BLUE, columns["primary_action"][:, number]
    return found
