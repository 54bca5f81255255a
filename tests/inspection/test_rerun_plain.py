"""A dataset of another robot, by the command that shows it, read back from the file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader

from pipeline.inspection.rerun_plain import action_names
from tests.command import run
from tests.episodes import random_episode, write
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


def test_two_arms_are_shown_side_by_side(tmp_path: Path) -> None:
    """Also where they have other cameras; each drive of the same words is a task's next one."""
    a = foreign(tmp_path / "a", videos=False)
    b = foreign(tmp_path / "b", videos=False, cameras=CAMERAS[:1], seed=1)
    path = tmp_path / "both.rrd"
    assert run(f"compare {a.path} {b.path} --drive 1 --save {path}") == 0
    [entry] = recordings(path)
    assert entry.recording_id == "stack the blocks/a_1/b_1"
    for root, arm in (("a", a), ("b", b)):
        joint = column(path, entry, f"/{root}/action/{JOINTS[3]}/action", "scalars")
        np.testing.assert_array_equal(joint, arm.columns(["action"])["action"][LENGTHS[0] :, 3])
        drove = column(path, entry, f"/{root}/who/drove", "state")
        assert drove == ["reference" if each else "primary" for each in DROVE[LENGTHS[0] :]]
    shown = {origin.strip("/") for origin in origins(path)}
    cameras = {f"a/{CAMERAS[0]}", f"a/{CAMERAS[1]}", f"b/{CAMERAS[0]}"}
    assert {origin for origin in shown if "observation" in origin} == cameras
    chunks = RrdReader(path).stream(store=entry).to_chunks()
    sent = {chunk.entity_path.removeprefix("/").replace("\\", "") for chunk in chunks}
    assert {entity for entity in sent if "observation" in entity} == cameras


def test_what_cannot_be_shown_is_one_line(tmp_path: Path, refused: Callable[..., str]) -> None:
    foreign(tmp_path / "arm", videos=False)
    assert "arm has no takeovers" in refused("inspect arm --unsafe")
    foreign(tmp_path / "other", videos=False, cameras=CAMERAS[:1])
    assert "no drive 2 of a task that is in both" in refused("compare arm other --drive 2")
    write(tmp_path / "car", [random_episode(np.random.default_rng(0), 4)])
    assert "car: fps is 10, expected 20 as in arm" in refused("compare arm car")
    assert "arm: fps is 20, expected 10 as in car" in refused("compare car arm")
    unknown = "0 frames have a safe probability, expected at least 1"
    assert unknown in refused("contact-sheet arm x.png --frames 1")


@pytest.mark.parametrize(
    ("names", "expected"),
    [(["a", "b"], ["a", "b"]), ({"motors": ["a", "b"]}, ["a", "b"]), (None, ["0", "1"])],
)
def test_numbers_of_an_action_have_names(names: object, expected: list[str]) -> None:
    assert list(action_names({"dtype": "float32", "shape": (2,), "names": names})) == expected
