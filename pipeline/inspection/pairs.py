"""Two drives on the same track, to be seen side by side."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from pipeline.data.reading import check_dataset, read_episodes
from pipeline.data.schema import CONTROL_HZ, Episode
from pipeline.inspection.footage import Footage, track_of
from pipeline.world.tracks import Track


@dataclass(frozen=True, eq=False)
class Pair:
    """Two drives on one track."""

    title: str
    name: str
    """A short one, of this pair only."""
    track: Track
    a: Footage
    b: Footage


def pairs(a: Path, b: Path, number: int = 0) -> list[Pair]:
    """Of two datasets: a pair for every track that both have, in the order of `a`.

    Where the two began on the track is up to them. In memory are the images of one drive on each
    track of either dataset, 35 kB each.

    Args:
        a: a dataset.
        b: another one.
        number: which of the drives on a track; 0 is the first.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`; other frame rates; no such drives on any
            track.
    """
    rates = [CONTROL_HZ // check_dataset(path) for path in (a, b)]
    if rates[0] != rates[1]:
        raise ValueError(f"{b} has {rates[1]} frames per second, expected the {rates[0]} of {a}")
    of_a, of_b = _on_each_track(a, number), _on_each_track(b, number)
    found = [
        Pair(
            f"{track}: a is {a.name}, episode {i}; b is {b.name}, episode {of_b[track][0]}",
            f"{track}/{a.name}_{i}/{b.name}_{of_b[track][0]}",
            track_of(episode.task),
            Footage.of_episode(episode),
            Footage.of_episode(of_b[track][1]),
        )
        for track, (i, episode) in of_a.items()
        if track in of_b
    ]
    if not found:
        raise ValueError(f"{a} and {b} have no drive {number} on a track that is in both")
    return found


def _on_each_track(path: Path, number: int) -> dict[str, tuple[int, Episode]]:
    """By the name of the track: the drive on it, and its number in the dataset."""
    found: dict[str, tuple[int, Episode]] = {}
    before: Counter[str] = Counter()
    for i, episode in enumerate(read_episodes(path)):
        track = track_of(episode.task).name
        if before[track] == number:
            found[track] = i, episode
        before[track] += 1
    return found
