"""Track sheets: each track from above, and a frame as the car sees it (the paper's appendix)."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Wedge
from numpy.typing import NDArray

from pipeline.driving.affordances import affordances
from pipeline.driving.cars import Cars
from pipeline.driving.tracks import Track, make_track
from pipeline.driving.traffic import start
from pipeline.driving.world import World
from pipeline.inspection.canvas import DPI, new_figure, styled

COLUMNS = 4  # tracks beside each other
MARGIN = 20.0  # [m] of ground around the largest track; all tracks of a sheet have one scale
TRAFFIC = 20  # cars in the sample frame's drive
GAP = (8.0, 30.0)  # [m] to the car ahead in the sample frame: well visible, not all there is
STARTS = 200  # to look for such a car in
ARROW = 30.0  # [m]
KEY = (
    "wedge: what the frame beneath shows",
    "dots: other cars",
    "arrow: from the start line in the direction of travel",
)
WEDGE = 36.0, 36.0  # [m] length, [degrees] half angle of what the camera sees

ToPixels = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""From world coordinates x, y [m], [N] each, to columns and rows of a picture, [N, 2]."""


def track_sheet(names: Sequence[str], title: str) -> Figure:
    """Two panels for each track: the top view, and beneath it a sample frame; ValueError without a name,
    or where there is no such track.
    """
    if not names:
        raise ValueError("there are no tracks, expected at least one name")
    tracks = [make_track(name) for name in names]
    extent = max(np.ptp([t.centreline.x, t.centreline.y], axis=1).max() for t in tracks)
    columns = min(len(tracks), COLUMNS)
    rows = -(-len(tracks) // columns)
    with new_figure(2.5 * columns, 4.1 * rows + 0.5) as figure:
        figure.suptitle(title, fontsize=12, fontweight="bold")
        figure.supxlabel(("; " if columns > 2 else "\n").join(KEY), fontsize=9)
        outer = figure.add_gridspec(rows, columns, hspace=0.06)
        for i, track in enumerate(tracks):
            panels = outer[divmod(i, columns)].subgridspec(2, 1, height_ratios=[2.5, 1.125])
            frame, cars = sample_frame(track)
            above, below = (figure.add_subplot(panels[half]) for half in range(2))
            _draw_track(above, track)
            _draw_start(above, track)
            _draw_cars(above, cars)
            _frame_map(above, track, extent / 2 + MARGIN)
            below.imshow(frame, interpolation="nearest")
            below.set_axis_off()
    return figure


def track_map(name: str, pixels: int) -> tuple[NDArray[np.uint8], ToPixels]:
    """A track from above, uint8 [H, pixels, 3], and where the world lies on it; raises as `make_track`."""
    track = make_track(name)
    line = track.centreline
    (left, right), (bottom, top) = (
        (along.min() - MARGIN, along.max() + MARGIN) for along in (line.x, line.y)
    )
    scale = pixels / (right - left)
    with styled():
        figure = Figure(figsize=(pixels / DPI, round((top - bottom) * scale) / DPI), dpi=DPI)
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0, 0, 1, 1), xlim=(left, right), ylim=(bottom, top))
        _draw_track(axes, track)
        _draw_start(axes, track)
        axes.set_axis_off()
        figure.set_facecolor(_rgb(track.look.ground))
        canvas.draw()
        picture = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def to_pixels(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([(x - left) * scale, (top - y) * scale], axis=1)

    return picture, to_pixels


def sample_frame(track: Track) -> tuple[NDArray[np.uint8], Cars]:
    """What the car sees, uint8 [72, 160, 3], and where all cars are; the same on each call."""
    seed = next(filter(lambda seed: _is_behind_a_car(track, seed), range(STARTS)), 0)
    with World(track, TRAFFIC, (0.0, 0.0), _random(track, seed)) as world:
        return world.image(), world.cars


def _is_behind_a_car(track: Track, seed: int) -> bool:
    cars = start(track, TRAFFIC, (0.0, 0.0), _random(track, seed))
    return bool(GAP[0] < affordances(cars, track)[6] < GAP[1])


def _random(track: Track, seed: int) -> np.random.Generator:
    return np.random.default_rng([track.seed, seed])


def _draw_track(axes: Axes, track: Track) -> None:
    """Road, lane markings, start line and direction, in the track's own colours."""
    line, look = track.centreline, track.look
    s = np.arange(801) * track.length / 800
    asphalt = (look.asphalt / 255,) * 3

    def along(d: float) -> tuple[NDArray, NDArray]:
        return line.position(s, np.full(len(s), d))

    axes.fill(*along(track.half_width), color=asphalt, linewidth=0)
    axes.fill(*along(-track.half_width), color=asphalt, linewidth=0)
    axes.fill(*along(_inwards(track) * track.half_width), color=_rgb(look.ground), linewidth=0)
    for d in track.lane_lines:
        axes.plot(*along(d), color=_rgb(look.line), linewidth=0.5, linestyle=(0, (4, 3)))
    for d in track.edge_lines:
        axes.plot(*along(d), color=_rgb(look.edge), linewidth=0.6)


def _draw_start(axes: Axes, track: Track) -> None:
    """The start line, and beside it an arrow in the direction of travel."""
    line = track.centreline
    x, y = line.position(np.zeros(2), np.array([-track.half_width, track.half_width]))
    axes.plot(x, y, color="black", linewidth=4.5, solid_capstyle="butt")
    axes.plot(x, y, color="white", linewidth=2.5, linestyle=(0, (1, 1)))
    tail = line.position(np.zeros(1), np.array([_inwards(track) * (track.half_width + 12.0)]))
    heading = line.heading_at(np.zeros(1))[0]
    axes.annotate(
        "",
        xy=(tail[0][0] + ARROW * np.cos(heading), tail[1][0] + ARROW * np.sin(heading)),
        xytext=(tail[0][0], tail[1][0]),
        arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.5, "shrinkA": 0},
    )


def _draw_cars(axes: Axes, cars: Cars) -> None:
    """The traffic, and the camera's car with what it looks at."""
    heading = np.degrees(cars.heading[0])
    centre = (float(cars.x[0]), float(cars.y[0]))
    view = Wedge(centre, WEDGE[0], heading - WEDGE[1], heading + WEDGE[1], color="#d55e00")
    view.set(alpha=0.45, zorder=3)
    axes.add_patch(view)
    dots: dict[str, Any] = {"edgecolor": "black", "linewidth": 0.5, "zorder": 4}
    axes.scatter(cars.x[1:], cars.y[1:], s=9, color="#f0e442", **dots)
    axes.scatter(cars.x[:1], cars.y[:1], s=22, color="#d55e00", **dots)


def _frame_map(axes: Axes, track: Track, reach: float) -> None:
    """Show `reach` [m] around the middle of the track, named, with a scale."""
    line = track.centreline
    x, y = (line.x.min() + line.x.max()) / 2 - reach, (line.y.min() + line.y.max()) / 2 - reach
    axes.set(xlim=(x, x + 2 * reach), ylim=(y, y + 2 * reach), aspect="equal", xticks=[], yticks=[])
    axes.set_facecolor(_rgb(track.look.ground))
    axes.spines[:].set_visible(False)
    axes.set_title(track.name, pad=16)
    facts = f"{track.lanes} lanes, {track.length:.0f} m a lap"
    axes.text(0, 1.02, facts, transform=axes.transAxes)
    axes.plot([x + 10, x + 60], [y + 10, y + 10], color="black", linewidth=2)
    axes.text(x + 35, y + 14, "50 m", ha="center", va="bottom", fontsize=8)


def _inwards(track: Track) -> int:
    """1 where the left side of the road is inside the loop, else -1."""
    x, y = track.centreline.x, track.centreline.y
    return 1 if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0 else -1


def _rgb(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    return colour[0] / 255, colour[1] / 255, colour[2] / 255
