"""Two drives on the same track, to be seen side by side."""

from collections import Counter
from dataclasses import dataclass

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes
from pipeline.data.schema import Episode
from pipeline.driving.features import FEATURES
from pipeline.driving.tracks import Track
from pipeline.inspection.excerpts import ending, judgement_of
from pipeline.inspection.footage import Footage, track_of
from pipeline.rollout.judgement import Judgement

Side = tuple[Footage, Judgement | None]
"""A drive, and by what its frames are judged."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two drives on one track."""

    title: str
    name: str
    """A short one, of this pair only."""
    track: Track
    a: Side
    b: Side


def pairs(a: Dataset, b: Dataset, number: int = 0) -> list[Pair]:
    """Of two datasets: a pair for every track that both have, in the order of `a`. `number` is which of
    the drives on a track, 0 the first. Where the two began on the track is up to them.

    In memory are the images of one drive on each track of either dataset, 35 kB each. ValueError for
    other frame rates or another robot's, and where there are no such drives on any track.
    """
    for dataset in (a, b):
        dataset.require(FEATURES)
    if a.fps != b.fps:
        raise ValueError(
            f"{b.path} has {b.fps} frames per second, expected the {a.fps} of {a.path}"
        )
    of_a, of_b = _on_each_track(a, number), _on_each_track(b, number)
    found = []
    for track in [track for track in of_a if track in of_b]:
        (i, drive_a), (j, drive_b) = of_a[track], of_b[track]
        title = (
            f"{track}: a is {a.path.name}, episode {i}{ending(a, i)}; "
            f"b is {b.path.name}, episode {j}{ending(b, j)}"
        )
        name = f"{track}/{a.path.name}_{i}/{b.path.name}_{j}"
        sides = _side(a, drive_a), _side(b, drive_b)
        found.append(Pair(title, name, track_of(drive_a.task), *sides))
    if not found:
        raise ValueError(f"{a.path} and {b.path} have no drive {number} on a track that is in both")
    return found


def _side(dataset: Dataset, drive: Episode) -> Side:
    judgement = judgement_of(dataset, drive)
    return Footage.of_episode(drive, judgement=judgement), judgement


def _on_each_track(dataset: Dataset, number: int) -> dict[str, tuple[int, Episode]]:
    """By the name of the track: the drive on it, and its number in the dataset."""
    chosen: dict[int, str] = {}
    before: Counter[str] = Counter()
    for i, task in enumerate(dataset.tasks):
        track = track_of(task).name
        if before[track] == number:
            chosen[i] = track
        before[track] += 1
    return {chosen[i]: (i, episode) for i, episode in read_episodes(dataset, chosen)}
