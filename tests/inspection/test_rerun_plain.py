"""A dataset of another robot, by the command that shows it, read back from the file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader

from pipeline.inspection.rerun_plain import action_names
from tests.command import run
from tests.foreign import CAMERAS, DROVE, JOINTS, LENGTHS, foreign
from tests.inspection.saved import column, origins, recordings


@pytest.mark.parametrize("videos", [False, True], ids=["images", "videos"])
def test_an_arm_is_shown(videos: bool, tmp_path: Path) -> None:
    arm = foreign(tmp_path / "arm", videos=videos)
    path = tmp_path / "arm.rrd"
    assert run(f"inspect {arm.path} --save {path}") == 0
    entries = recordings(path)
    assert [entry.recording_id for entry in entries] == ["arm/episode_0000", "arm/episode_0001"]
    drove = column(path, entries[0], "/who/drove", "state")
    assert drove == ["reference" if each else "primary" for each in DROVE[: LENGTHS[0]]]
    asked = column(path, entries[0], "/who/was_asked", "state")
    assert asked == ["reference" if each else "" for each in DROVE[: LENGTHS[0]]]
    joint = column(path, entries[1], f"/action/{JOINTS[3]}/action", "scalars")
    np.testing.assert_array_equal(joint, arm.columns(["action"])["action"][LENGTHS[0] :, 3])
    for entry, length in zip(entries, LENGTHS, strict=True):
        rows = {name: 0 for name in CAMERAS}
        for chunk in RrdReader(path).stream(store=entry).to_chunks():
            name = chunk.entity_path.removeprefix("/").replace("\\", "")
            if name in rows and chunk.timeline_names:
                rows[name] += chunk.num_rows
        assert rows == dict.fromkeys(CAMERAS, length)
    shown = {origin.strip("/") for origin in origins(path)}
    assert {*CAMERAS, "who", *(f"action/{name}" for name in JOINTS)} <= shown


def test_what_cannot_be_shown_is_one_line(tmp_path: Path, refused: Callable[..., str]) -> None:
    foreign(tmp_path / "arm", videos=False)
    assert "arm has no takeovers" in refused("inspect arm --unsafe")
    assert "arm: column 'observation.images.front' is missing" in refused("compare arm arm")
    unknown = "0 frames have a safe probability, expected at least 1"
    assert unknown in refused("contact-sheet arm x.png --frames 1")


@pytest.mark.parametrize(
    ("names", "expected"),
    [(["a", "b"], ["a", "b"]), ({"motors": ["a", "b"]}, ["a", "b"]), (None, ["0", "1"])],
)
def test_numbers_of_an_action_have_names(names: object, expected: list[str]) -> None:
    assert list(action_names({"dtype": "float32", "shape": (2,), "names": names})) == expected
