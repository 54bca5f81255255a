"""The top view in Rerun: the road, the line that our car drove by who drove, and the cars.

North is up, as on the maps: Rerun's y points down, so all y are turned around. In the shapes, T is
the number of frames.
"""

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from pipeline.driving.cars import LENGTH, WIDTH
from pipeline.driving.tracks import Track
from pipeline.inspection.footage import Footage
from pipeline.inspection.rerun_traces import Trace

YELLOW, WHITE = 0xF0E442FF, 0xFFFFFFFF
STEP = 1.5  # [m] between the points of a line along the road
LINE, DRIVEN, ARROW = 0.13, 0.45, 0.5  # [m] half the width of the lines
NOSE = 9.0  # [m] from the middle of our car to the tip of its arrow
ROAD, PAINT, WAY, CARS, OURS = 0.0, 1.0, 2.0, 3.0, 4.0  # what lies on what


def log_track(recording: rr.RecordingStream, track: Track) -> None:
    """The asphalt, the edge lines and the dashes between the lanes, in the track's own colours."""
    look, line = track.look, track.centreline
    lap = np.linspace(0.0, track.length, round(track.length / STEP) + 1)

    def along(s: NDArray, d: float) -> NDArray:
        return _flipped(np.stack(line.position(s, np.full(s.shape, d)), axis=-1))

    def draw(entity: str, strips: list, color: tuple, radius: float, order: float) -> None:
        strip = rr.LineStrips2D(strips, colors=color, radii=radius, draw_order=order)
        recording.log(f"track/{entity}", strip, static=True)

    dashes = np.arange(0.0, track.length - look.dash[0], sum(look.dash))
    ends = dashes[:, None] + np.array([0.0, look.dash[0]])
    draw("asphalt", [along(lap, 0.0)], (look.asphalt,) * 3, track.half_width, ROAD)
    edges = [along(lap, d) for d in track.edge_lines]
    lines = [dash for d in track.lane_lines for dash in along(ends, d)]
    draw("edges", edges, look.edge, LINE, PAINT)
    draw("lanes", lines, look.line, LINE, PAINT)


def top_view(*, primary: int, reference: int, label: str | None = None) -> list[Trace]:
    """What moves in the top view; our car and its line have the colour of who drives."""

    def colors(footage: Footage) -> NDArray[np.uint32]:
        return np.where(footage.intervention, reference, primary).astype(np.uint32)

    def driven(footage: Footage) -> rr.ComponentColumnList:
        strips = _flipped(np.stack([footage.vehicle_state[:, :2], footage.end], axis=1))
        return rr.LineStrips2D.columns(strips=list(strips), colors=colors(footage))

    def others(footage: Footage) -> rr.ComponentColumnList:
        strips = _strips(np.concatenate(footage.others))
        columns = rr.LineStrips2D.columns(strips=list(strips))
        return columns.partition([len(cars) for cars in footage.others])

    def ours(footage: Footage) -> rr.ComponentColumnList:
        strips = _strips(footage.vehicle_state[:, :3])
        return rr.LineStrips2D.columns(strips=list(strips), colors=colors(footage))

    def heading(footage: Footage) -> rr.ComponentColumnList:
        origins, tips = _flipped(footage.vehicle_state[:, :2]), _ahead(footage.vehicle_state, NOSE)
        return rr.Arrows2D.columns(origins=origins, vectors=tips)

    look = rr.LineStrips2D.from_fields
    return [
        Trace("top_view/driven", look(radii=DRIVEN, draw_order=WAY), driven),
        Trace("top_view/others", look(colors=YELLOW, radii=WIDTH / 2, draw_order=CARS), others),
        Trace("top_view/car", look(radii=WIDTH / 2, draw_order=OURS, labels=label), ours),
        Trace(
            "top_view/heading",
            rr.Arrows2D.from_fields(colors=WHITE, radii=ARROW, draw_order=OURS),
            heading,
        ),
    ]


def _strips(poses: NDArray) -> NDArray:
    """[M, 2, 2] thick lines, whose round ends are bumpers, for cars at `poses` [M, 3] (m, m, rad)."""
    middle, front = _flipped(poses[:, :2]), _ahead(poses, 0.5 * (LENGTH - WIDTH))
    return np.stack([middle - front, middle + front], axis=1)


def _ahead(poses: NDArray, distance: float) -> NDArray:
    """[M, 2] from each of the cars at `poses` [M, 3 or more] to a point `distance` [m] ahead."""
    return _flipped(distance * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1))


def _flipped(points: NDArray) -> NDArray:
    """`points`, [..., 2], with their y turned around."""
    return points * np.array([1, -1], points.dtype)
