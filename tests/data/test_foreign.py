"""A dataset that somebody else has written is opened, selected from, merged and counted."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes, read_images
from pipeline.data.ledger import count
from pipeline.data.merging import merge
from pipeline.data.selecting import sample, select
from tests.files import tree
from tests.foreign import CAMERAS, DROVE, foreign


@pytest.fixture(scope="module", params=[False, True], ids=["images", "videos"])
def arm(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Dataset:
    return foreign(tmp_path_factory.mktemp("foreign") / "rollout_arm", videos=request.param)


def test_it_opens(arm: Dataset) -> None:
    assert (len(arm), arm.fps, arm.info["robot_type"]) == (10, 20, "arm")
    assert sorted(arm.cameras) == sorted(CAMERAS)
    assert arm.tasks == ["stack the blocks"] * 2
    assert arm.column("queried").tolist() == DROVE


def test_other_ways_to_say_the_same_that_lerobot_takes(arm: Dataset, tmp_path: Path) -> None:
    """Channels that come first by their names, and tasks without a name for what they are."""
    path = tmp_path / "otherwise"
    shutil.copytree(arm.path, path)
    file = path / "meta" / "info.json"
    info = json.loads(file.read_text())
    for camera in CAMERAS:
        height, width, channels = info["features"][camera]["shape"]
        said = {"shape": [channels, height, width], "names": ["channels", "height", "width"]}
        info["features"][camera] |= said
    file.write_text(json.dumps(info))
    tasks = pd.read_parquet(path / "meta" / "tasks.parquet")
    tasks.rename_axis(None).to_parquet(path / "meta" / "tasks.parquet")
    otherwise = Dataset.open(path)
    assert otherwise.tasks == arm.tasks
    assert otherwise.features == arm.features
    for camera in CAMERAS:
        assert brightness(otherwise, camera).tolist() == brightness(arm, camera).tolist()


def brightness(dataset: Dataset, camera: str) -> np.ndarray:
    """Of each picture: videos lose a little."""
    return read_images(dataset, camera)[:].mean(axis=(1, 2, 3))


def test_its_pictures_are_read(arm: Dataset) -> None:
    for camera in CAMERAS:
        np.testing.assert_allclose(brightness(arm, camera), np.arange(10) * 20, atol=6)
    (_, episode) = next(read_episodes(arm, [1]))
    assert len(episode) == 4
    assert episode.columns[CAMERAS[1]].shape == (4, 64, 96, 3)


def test_what_the_person_drove_is_selected_merged_and_counted(
    arm: Dataset, tmp_path: Path, load: Callable
) -> None:
    before = tree(arm.path)
    assert select(arm, tmp_path / "new").frames == sum(DROVE)
    new = Dataset.open(tmp_path / "new")
    assert new.lengths.tolist() == [2, 1, 1]
    kept = np.flatnonzero(DROVE)
    for name in ("action", "observation.state"):
        expected = arm.columns([name])[name][kept]
        np.testing.assert_array_equal(new.columns([name])[name], expected)
    for camera in CAMERAS:
        np.testing.assert_allclose(brightness(new, camera), kept * 20, atol=6)
    # LeRobot's loader finds the same pictures
    loaded = load(new.path)
    for index, row in enumerate(kept):
        shown = float(loaded[index][CAMERAS[0]].mean()) * 255
        assert shown == pytest.approx(row * 20, abs=6)

    sample(arm, tmp_path / "some", sum(DROVE), seed=0)
    with pytest.raises(ValueError, match="some: 4 of its frames are in"):
        merge([new, Dataset.open(tmp_path / "some")], tmp_path / "both")
    videos = arm.info["video_path"] is not None
    select(foreign(tmp_path / "another", videos=videos, seed=1), tmp_path / "other")
    other = Dataset.open(tmp_path / "other")
    merge([new, other], tmp_path / "both")
    both = Dataset.open(tmp_path / "both")
    assert len(both) == len(new) + len(other)
    for camera in CAMERAS:
        expected = np.concatenate([brightness(new, camera), brightness(other, camera)])
        np.testing.assert_allclose(brightness(both, camera), expected, atol=6)
    assert float(load(both.path)[len(new)][CAMERAS[1]].mean()) * 255 == pytest.approx(20, abs=6)
    counted = {
        "frames_driven": 10,
        "queries": 4,
        "frames_selected": 4,
        "frames_trained": len(both),
        "takeover": 0.4,
        "frames_of_calls": 4,
        "drives": len(arm.lengths),
        # nobody wrote down how the drives ended
        "put_back": None,
        "failures": None,
    }
    assert counted.items() <= count(arm, both).items()
    assert tree(arm.path) == before


def test_a_car_and_an_arm_do_not_merge(arm: Dataset, d_0: Dataset, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=f"^{arm.path}: fps is 20, expected 10 as in {d_0.path}$"):
        merge([d_0, arm], tmp_path / "D_1")
