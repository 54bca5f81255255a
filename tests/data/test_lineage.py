import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.data.dataset import Dataset
from pipeline.data.lineage import FILE, Lineage, Recipe
from pipeline.data.merging import merge
from tests.data.spoiling import copy
from tests.episodes import random_episode, write


def test_it_says_what_it_is_and_what_it_was_made_from(
    d_0: Dataset, rollout_1: Dataset, new_1: Dataset, tmp_path: Path
) -> None:
    merge([d_0, new_1], tmp_path / "D_1")
    lineage = Dataset.open(tmp_path / "D_1").lineage
    assert lineage.own.purpose == "merge"
    start, added = lineage.parents
    assert (start.sha256, start.own.purpose) == (d_0.lineage.sha256, "D_0")
    assert added.own.purpose == "select"
    (driven,) = added.parents
    assert driven.own == rollout_1.lineage.own
    assert driven.own.arguments["cut"] == 0.5
    text = (tmp_path / "D_1" / FILE).read_text()
    assert str(tmp_path) not in text and str(d_0.path.parent) not in text


def test_its_id_fits_into_a_column_and_names_where_a_frame_was_recorded(
    d_0: Dataset, rollout_1: Dataset, d_1: Dataset
) -> None:
    for dataset in (d_0, rollout_1):
        own = dataset.lineage.id
        assert 0 <= own < 2**63
        assert f"{own:016x}" == f"{int(dataset.lineage.sha256[:16], 16) // 2:016x}"
        assert set(dataset.column("source.dataset").tolist()) == {own}
    source = d_1.column("source.dataset")
    assert source.tolist() == [d_0.lineage.id] * 7 + [rollout_1.lineage.id] * 10


def test_what_differs_in_a_pixel_or_an_argument_is_another_dataset(tmp_path: Path) -> None:
    def written(name: str, *, pixel: int = 0, **arguments: int) -> str:
        episode = random_episode(np.random.default_rng(0), 2)
        episode.columns["observation.images.front"][0, 0, 0, 0] = pixel
        return write(tmp_path / name, [episode], **arguments).lineage.sha256

    one, same = written("one", seed=1), written("same", seed=1)
    assert one == same
    assert len({one, written("pixel", pixel=9, seed=1), written("argument", seed=2)}) == 3


def test_of_a_foreign_dataset_the_data_files_are_what_it_is(d_0: Dataset, tmp_path: Path) -> None:
    path = copy(d_0, tmp_path / "D")
    (path / FILE).unlink()
    foreign = Dataset.open(path).lineage
    assert foreign.own.purpose == "foreign" and foreign.parents == []
    assert foreign.sha256 == Dataset.open(path).lineage.sha256 != d_0.lineage.sha256


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"sha256": "a", "made": {}}', '{"made": 3}'])
def test_refuses_what_is_none_of_ours(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    with pytest.raises(ValueError, match=f"{FILE}: .*, expected what safedagger writes there"):
        Lineage.read(tmp_path)


def test_written_and_read_it_is_the_same(tmp_path: Path) -> None:
    parent = Recipe("D_0", {"seed": 1}).lineage("ab" * 32)
    child = Recipe("select", {}, [parent]).lineage("cd" * 32)
    child.write(tmp_path)
    assert Lineage.read(tmp_path) == child
    assert json.loads((tmp_path / FILE).read_text())["made"].keys() == {"ab" * 32, "cd" * 32}
    assert Lineage.read(tmp_path / "nowhere") is None
