"""Two datasets side by side, read back from the file."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader

from pipeline.data.dataset import Dataset
from pipeline.data.schema import Episode
from pipeline.driving.features import CAMERA
from pipeline.inspection.pairs import pairs
from pipeline.inspection.rerun_blueprints import pair_blueprint
from pipeline.inspection.rerun_log import BLUE, LIGHT_BLUE, ORANGE, RED, log_pair
from pipeline.inspection.rerun_sinks import into_file
from tests.episodes import LABELS, random_episode, write
from tests.inspection.saved import column, origins, recordings

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


@pytest.mark.parametrize(
    ("number", "expected"),
    [(0, {"alder": (0, 1), "birch": (1, 2)}), (1, {"alder": (2, 3)})],
)
def test_a_pair_for_each_track_of_both(
    datasets: tuple[Dataset, Dataset], number: int, expected: dict[str, tuple[int, int]]
) -> None:
    found = pairs(*datasets, number)
    assert [pair.title for pair in found] == [
        f"{track}: a is a, episode {i}; b is b, episode {j}" for track, (i, j) in expected.items()
    ]
    for pair, (i, j) in zip(found, expected.values(), strict=True):
        for (footage, _), (seed, tracks), episode in ((pair.a, OF_A, i), (pair.b, OF_B, j)):
            expected = episodes(seed, tracks)[episode]
            assert pair.track.name in expected.task
            np.testing.assert_array_equal(footage.image, expected.columns[CAMERA])


def test_what_cannot_be_paired(datasets: tuple[Dataset, Dataset], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no drive 2 on a track that is in both"):
        pairs(*datasets, 2)
    slow = write(tmp_path / "slow", episodes(2, ("alder",)), fps=2)
    with pytest.raises(ValueError, match="2 frames per second, expected the 10"):
        pairs(datasets[0], slow)


def test_both_drives_are_in_one_recording(
    datasets: tuple[Dataset, Dataset], tmp_path: Path
) -> None:
    found, path = pairs(*datasets), tmp_path / "pairs.rrd"
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
    drives = {"a": (found[0].a[0], BLUE, RED), "b": (found[0].b[0], LIGHT_BLUE, ORANGE)}
    for root, (footage, primary, reference) in drives.items():
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
