"""Two datasets side by side, read back from the file."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Episode
from pipeline.driving.features import CAMERA
from pipeline.inspection.footage import Footage, track_of
from pipeline.inspection.pairs import Pair, pairs
from pipeline.inspection.rerun_blueprints import pair_blueprint
from pipeline.inspection.rerun_log import BLUE, LIGHT_BLUE, ORANGE, RED, log_pair
from pipeline.inspection.rerun_sinks import into_file
from tests.episodes import LABELS, random_episode, write
from tests.inspection.saved import column, origins, recordings

TITLE = "{}: a is a, episode {}; b is b, episode {}"
OF_A = 0, ("alder", "birch", "alder", "random:7")
OF_B = 1, ("yew", "alder", "birch", "alder")


def episodes(seed: int, tracks: tuple[str, ...]) -> list[Episode]:
    rng = np.random.default_rng(seed)
    return [
        random_episode(rng, 4 + i, task=f"drive on {track} with 5 other cars", episode=i)
        for i, track in enumerate(tracks)
    ]


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory) -> tuple[Dataset, Dataset]:
    a, b = (tmp_path_factory.mktemp("datasets") / name for name in "ab")
    return (
        write(a, episodes(*OF_A), "rollout", cut=0.5, labels=LABELS | {"tau": 0.01}),
        write(b, episodes(*OF_B), "rollout", cut=0.5, labels=LABELS | {"tau": 0.02}),
    )


def pairs_on_a_track(a: Dataset, b: Dataset, number: int = 0) -> list[Pair]:
    return list(pairs(a, b, number, place=lambda task: track_of(task).name))


@pytest.mark.parametrize(
    ("number", "expected"),
    [(0, {"alder": (0, 1), "birch": (1, 2)}), (1, {"alder": (2, 3)})],
)
def test_a_pair_for_each_track_of_both(
    datasets: tuple[Dataset, Dataset], number: int, expected: dict[str, tuple[int, int]]
) -> None:
    found = pairs_on_a_track(*datasets, number)
    assert [pair.title for pair in found] == [
        TITLE.format(track, i, j) for track, (i, j) in expected.items()
    ]
    for pair, (i, j) in zip(found, expected.values(), strict=True):
        for drive, (seed, tracks), number in ((pair.a, OF_A, i), (pair.b, OF_B, j)):
            written = episodes(seed, tracks)[number]
            assert drive.episode.task == written.task
            np.testing.assert_array_equal(drive.episode.columns[CAMERA], written.columns[CAMERA])


def test_a_task_is_all_its_words_where_nothing_else_is_said(
    datasets: tuple[Dataset, Dataset], tmp_path: Path
) -> None:
    """Among more cars it is another task, though on the same track."""
    [episode] = episodes(2, ("alder",))
    fuller = replace(episode, task="drive on alder with 6 other cars")
    b = write(tmp_path / "b", [fuller, *episodes(3, ("birch",))])
    [pair] = pairs(datasets[0], b)
    assert pair.title == TITLE.format("drive on birch with 5 other cars", 1, 1)
    assert [pair.title for pair in pairs_on_a_track(datasets[0], b)] == [
        TITLE.format("alder", 0, 0),
        TITLE.format("birch", 1, 1),
    ]


def test_what_cannot_be_paired(datasets: tuple[Dataset, Dataset], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no drive 2 of a task that is in both"):
        pairs(*datasets, 2)
    slow = write(tmp_path / "slow", episodes(2, ("alder",)), fps=2)
    with pytest.raises(ValueError, match="slow: fps is 2, expected 10 as in"):
        pairs(datasets[0], slow)


def test_both_drives_are_in_one_recording(
    datasets: tuple[Dataset, Dataset], tmp_path: Path
) -> None:
    found, path = pairs_on_a_track(*datasets), tmp_path / "pairs.rrd"
    with into_file(path, pair_blueprint(10)) as sink:
        for pair in found:
            log_pair(pair, sink.connect, fps=10)
    entries = recordings(path)
    assert {entry.recording_id for entry in entries} == {pair.name for pair in found}
    entry = next(entry for entry in entries if entry.recording_id.startswith("alder"))
    rows: Counter[str] = Counter()
    for chunk in RrdReader(path).stream(store=entry).to_chunks():
        if chunk.timeline_names:
            rows[chunk.entity_path] += chunk.num_rows
    drives = {"a": (found[0].a, BLUE, RED), "b": (found[0].b, LIGHT_BLUE, ORANGE)}
    for root, (drive, primary, reference) in drives.items():
        footage = Footage.of_episode(drive.episode, judgement=drive.judgement)
        counts = {entity: n for entity, n in rows.items() if entity.startswith(f"/{root}/")}
        assert f"/{root}/camera" in counts and set(counts.values()) == {len(footage)}
        drove = np.where(footage.intervention, reference, primary)
        assert column(path, entry, f"/{root}/top_view/driven", "colors") == drove.tolist()
        probability = column(path, entry, f"/{root}/safe_probability/safe_probability", "scalars")
        np.testing.assert_array_equal(probability, footage.safe_probability)
        (tau,) = set(column(path, entry, f"/{root}/deviation/tau", "scalars"))
        assert tau == {"a": 0.01, "b": 0.02}[root]
        for view in ("camera", "who", "action", "safe_probability", "deviation", "speed"):
            assert f"{root}/{view}" in {origin.strip("/") for origin in origins(path)}
