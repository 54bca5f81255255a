"""Where the Rerun viewer shows what."""

from collections.abc import Sequence

import rerun.blueprint as rrb


def drive_blueprint(fps: int) -> rrb.Blueprint:
    """For recordings of one drive each, of `fps` frames per second."""
    around = rrb.StateTimelineView(origin="around", name="what is there")
    return _blueprint(
        fps,
        rrb.Vertical(
            *_seen(),
            rrb.StateTimelineView(origin="who", name="who drove, and was there reason to"),
            row_shares=[9, 14, 6],
        ),
        rrb.Vertical(
            *_plots(),
            rrb.Horizontal(_plot("distance", "distances [m]"), around),
            row_shares=[5, 4, 4, 4, 4, 7],
        ),
        column_shares=[2, 3],
    )


def live_blueprint(fps: int) -> rrb.Blueprint:
    """For a drive that is still being driven. It has no lanes: they would not move on with it."""
    return _blueprint(
        fps,
        rrb.Vertical(*_seen(), row_shares=[2, 3]),
        rrb.Vertical(*_plots(), _plot("distance", "distances [m]"), row_shares=[5, 4, 4, 4, 4, 5]),
        column_shares=[1, 1],
    )


def pair_blueprint(fps: int) -> rrb.Blueprint:
    """For recordings of two drives each, of `fps` frames per second."""
    return _blueprint(
        fps,
        *(
            rrb.Vertical(
                rrb.Spatial2DView(origin=f"{root}/camera", name=f"{root}: camera"),
                rrb.StateTimelineView(origin=f"{root}/who", name=f"{root}: who drove"),
                _plot(f"{root}/action", f"{root}: steering and brake"),
                _plot(f"{root}/safe_probability", f"{root}: safe probability", (0.0, 1.0)),
                _plot(f"{root}/deviation", f"{root}: deviation"),
                row_shares=[8, 6, 6, 5, 5],
            )
            for root in "ab"
        ),
        rrb.Vertical(
            _top_view(["a/", "b/"], "top view: a is dark, b is light"),
            _plot("a/speed", "a: speed [m/s]"),
            _plot("b/speed", "b: speed [m/s]"),
            row_shares=[4, 1, 1],
        ),
        column_shares=[3, 3, 4],
    )


def _blueprint(fps: int, *columns: rrb.Vertical, column_shares: Sequence[float]) -> rrb.Blueprint:
    return rrb.Blueprint(
        rrb.Horizontal(*columns, column_shares=column_shares),
        rrb.TimePanel(timeline="frame_index", state="collapsed", fps=fps),
        rrb.BlueprintPanel(state="expanded"),  # lists the recordings
        rrb.SelectionPanel(state="hidden"),
    )


def _seen() -> list[rrb.Spatial2DView]:
    """By the camera, and from above."""
    return [rrb.Spatial2DView(origin="camera", name="camera"), _top_view([""], "top view")]


def _plots() -> list[rrb.TimeSeriesView]:
    """What is plotted of every single drive."""
    return [
        _plot("action", "steering and brake"),
        _plot("safe_probability", "safe probability, and where the reference drives", (0.0, 1.0)),
        _plot("deviation", "deviation"),
        _plot("in_lane", "position in the lane and angle to it"),
        _plot("speed", "speed [m/s]"),
    ]


def _top_view(roots: list[str], name: str) -> rrb.Spatial2DView:
    """The track with the drives at `roots`; of the lines that they drove, all is seen at any time."""
    ever = rrb.TimeRangeBoundary.infinite()
    always = rrb.VisibleTimeRanges(
        [
            rrb.VisibleTimeRange(timeline, start=ever, end=ever)
            for timeline in ("frame_index", "timestamp")
        ]
    )
    return rrb.Spatial2DView(
        origin="/",
        contents=["/track/**", *(f"/{root}top_view/**" for root in roots)],
        name=name,
        overrides={f"{root}top_view/driven": always for root in roots},
    )


def _plot(origin: str, name: str, axis: tuple[float, float] | None = None) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_y=None if axis is None else rrb.ScalarAxis(range=axis),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
    )
