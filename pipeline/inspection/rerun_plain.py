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
from pipeline.inspection.rerun_log import BLUE, GREEN, ORANGE, RED, Connect, new_recording

QUALITY = 90  # of the JPEG: a camera of a robot is larger than the car's


def plain_blueprint(dataset: Dataset) -> rrb.Blueprint:
    """Cameras above each other, and beside them who drove and what was done."""
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(*(rrb.Spatial2DView(origin=name, name=name) for name in dataset.cameras)),
            rrb.Vertical(
                rrb.StateTimelineView(origin="who", name="who drove, who was asked"),
                rrb.TimeSeriesView(origin="safe_probability", name="safe probability"),
                *(
                    rrb.TimeSeriesView(origin=f"action/{name}", name=f"action: {name}")
                    for name in action_names(dataset.features["action"])
                ),
            ),
            column_shares=[2, 3],
        ),
        rrb.TimePanel(timeline="frame_index", state="collapsed", fps=dataset.fps),
        rrb.SelectionPanel(state="hidden"),
    )


def log_plain(excerpt: Excerpt, connect: Connect, *, fps: int) -> None:
    """Send an excerpt as one recording; `connect` is called once, before anything is sent."""
    episode = excerpt.episode
    columns, features = episode.columns, episode.features
    numbers = np.arange(len(episode)) + excerpt.first_frame
    times = [
        rr.TimeColumn("frame_index", sequence=numbers),
        rr.TimeColumn("timestamp", duration=numbers / fps),
    ]
    with new_recording(excerpt.name, excerpt.title, None, connect) as recording:

        def send(entity: str, shown: rr.ComponentColumnList) -> None:
            recording.send_columns(entity, times, shown)

        for name in (n for n, of in features.items() if of["dtype"] in ("image", "video")):
            for number, image in zip(numbers, columns[name], strict=True):
                recording.set_time("frame_index", sequence=int(number))
                recording.set_time("timestamp", duration=float(number / fps))
                recording.log(name, rr.Image(image).compress(jpeg_quality=QUALITY))
        recording.reset_time()
        done = _lines(columns, features["action"])
        for entity, (color, values) in done.items():
            label = entity.rsplit("/")[-1]
            recording.log(entity, rr.SeriesLines(names=label, colors=color), static=True)
            send(entity, rr.Scalars.columns(scalars=values))
        for entity, (words, color, flags) in {
            "who/drove": (("reference", "primary"), RED, columns["intervention"]),
            "who/was_asked": (("reference", ""), ORANGE, columns["queried"]),
        }.items():
            known = [word for word in words if word]
            look = rr.StateConfiguration(values=known, colors=[color, BLUE][: len(known)])
            recording.log(entity, look, static=True)
            states = np.where(flags[:, 0], *words).tolist()
            send(entity, rr.StateChange.columns(state=states))


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
