import pytest

from pipeline.driving.task import Driving


def test_a_range_of_random_tracks_is_one_track_after_the_other() -> None:
    tracks = Driving(tracks="alder, random:7-9,random:3").scenarios
    assert tracks == ["alder", "random:7", "random:8", "random:9", "random:3"]


@pytest.mark.parametrize("tracks", ["random:9-7", "alder,oak-3", "random:1-", "random:-1"])
def test_what_is_no_range_is_no_track_either(tracks: str) -> None:
    bad = tracks.split(",")[-1]
    with pytest.raises(ValueError, match=f"^track '{bad}': expected one of alder, .*random"):
        Driving(tracks=tracks)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("traffic", -1), ("traffic", 10_000), ("seconds", 0.0), ("seconds", float("nan"))],
        *[("laps", -1.0), ("action_repeat", 7), ("offset_spread", -0.1)],
    ],
)
def test_a_setting_out_of_range_is_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{name} is {value}, expected"):
        Driving(**{name: value})
