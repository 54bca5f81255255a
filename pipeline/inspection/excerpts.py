"""What is to be seen of a dataset: all of its episodes, or its takeovers only, where the reference took the
wheel because the safety policy said unsafe.

In the shapes, N is the number of rows of a dataset.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes
from pipeline.data.pieces import runs
from pipeline.data.schema import Episode
from pipeline.rollout.judgement import Judgement, judgements

JUDGED = ("intervention", "queried", "safe_probability", "deviation")
"""The columns that tell of takeovers."""
BEFORE, AFTER = 2.0, 1.0  # [s] of a window around its takeover


@dataclass(frozen=True)
class Takeover:
    """Successive frames of one episode that the reference drove, and a window around them."""

    episode: int
    start: int
    """The first frame that the reference drove, counted within the episode."""
    stop: int
    """The frame after the last one that it drove."""
    first: int
    """The first frame of the window: 2 s before the takeover, or where the episode begins."""
    end: int
    """The frame after the window's last: 1 s after the takeover, or where the episode ends."""
    safe_probability: float
    """The lowest in the takeover: how unsafe it was."""
    deviation: float
    """The highest in the takeover; NaN where it is not known."""
    queries: int
    """What it cost."""

    def __str__(self) -> str:
        return (
            f"episode {self.episode}, frames {self.start} to {self.stop - 1}: safe probability "
            f"{self.safe_probability:.3f}, deviation {self.deviation:.4f}, {self.queries} queries"
        )


def takeovers(
    columns: Mapping[str, NDArray], episode_index: NDArray[np.int64], *, fps: int
) -> list[Takeover]:
    """All takeovers, most unsafe first, equally unsafe ones in the order of the dataset.

    What the reference drove without a safety policy is no takeover. `columns` are those of JUDGED,
    each [N]; `episode_index`, [N], never falls.
    """
    found: list[Takeover] = []
    for episode in np.unique(episode_index):
        rows = {name: columns[name][episode_index == episode] for name in JUDGED}
        taken = rows["intervention"] & ~np.isnan(rows["safe_probability"])
        found += [
            Takeover(
                int(episode),
                run.start,
                run.stop,
                max(run.start - round(BEFORE * fps), 0),
                min(run.stop + round(AFTER * fps), len(taken)),
                float(rows["safe_probability"][run].min()),
                float(rows["deviation"][run].max()),
                int(rows["queried"][run].sum()),
            )
            for run in runs(taken)
        ]
    return sorted(found, key=lambda takeover: takeover.safe_probability)


@dataclass(frozen=True, eq=False)
class Excerpt:
    """Successive rows of one episode."""

    title: str
    """Titles sort as the excerpts of one dataset do."""
    name: str
    """A short one, of this excerpt only."""
    episode: Episode
    first_frame: int
    """`frame_index` of the first row."""
    judgement: Judgement | None = None
    """By what its frames were judged; None without a safety policy."""

    def __len__(self) -> int:
        return len(self.episode)


def whole_episodes(dataset: Dataset, only: int | None = None) -> Iterator[Excerpt]:
    """Every episode of a dataset, or `only` one of them, in order, and read one at a time; ValueError, at
    once, where there is no such episode.
    """
    _check_episode(dataset, only)
    name = dataset.path.name
    return (
        Excerpt(
            f"episode {i:04d}: {_origin(episode)}{ending(dataset, i)}",
            f"{name}/episode_{i:04d}",
            episode,
            0,
            judgement_of(dataset, episode),
        )
        for i, episode in read_episodes(dataset, None if only is None else [only])
    )


def ranked_takeovers(dataset: Dataset, only: int | None = None) -> list[Takeover]:
    """The takeovers of all episodes, or of `only` one, most unsafe first; ValueError as `whole_episodes`,
    or where there is none.
    """
    _check_episode(dataset, only)
    columns = {name: column[:, 0] for name, column in dataset.columns(JUDGED).items()}
    chosen = [
        takeover
        for takeover in takeovers(columns, dataset.episode_index, fps=dataset.fps)
        if only in (None, takeover.episode)
    ]
    if not chosen:
        where = dataset.path if only is None else f"{dataset.path}: episode {only}"
        raise ValueError(f"{where} has no takeovers, expected some of a safety policy's")
    return chosen


def megabytes(dataset: Dataset, frames: int, recordings: int) -> float:
    """About how large a file so many frames of the car's, in so many recordings, come to: their
    pictures as they are stored, 3.4 kB of lines beside each, and 135 kB of track beneath all."""
    stored = sum(file.stat().st_size for file in dataset.data_files) / len(dataset)
    return (frames * (stored + 3400) + recordings * 135_000) / 1e6


def judgement_of(dataset: Dataset, episode: Episode) -> Judgement | None:
    """By what the frames of an episode were judged: by the rollout that they are from."""
    source = int(episode.columns["source.dataset"][0, 0])
    return judgements(dataset.lineage).get(source)


def around_takeovers(dataset: Dataset, ranked: Sequence[Takeover]) -> Iterator[Excerpt]:
    """The window around each takeover, read one at a time.

    Their titles rank them, as `ranked` does. The first comes last, where a viewer stays; the others
    come in the order of the dataset: to have their images in order, all of them would have to be in
    memory.
    """
    of_episode: dict[int, list[tuple[int, Takeover]]] = {}
    for rank, takeover in enumerate(ranked, 1):
        of_episode.setdefault(takeover.episode, []).append((rank, takeover))
    first: list[Excerpt] = []
    for i, episode in read_episodes(dataset, of_episode):
        for rank, takeover in of_episode[i]:
            excerpt = Excerpt(
                f"takeover {rank:04d}: {takeover}, {_origin(episode)}",
                f"{dataset.path.name}/takeover_{rank:04d}",
                episode.rows(takeover.first, takeover.end),
                takeover.first,
                judgement_of(dataset, episode),
            )
            if rank == 1:
                first.append(excerpt)
            else:
                yield excerpt
    yield from first


def ending(dataset: Dataset, episode: int) -> str:
    """Why the drive of an episode ended, to be added to a line; nothing where nobody knows it."""
    drives = dataset.drives
    return "" if drives.empty else f"; ended: {drives.ended[episode]}"


def _check_episode(dataset: Dataset, only: int | None) -> None:
    last = len(dataset.lengths) - 1
    if last < 0:
        raise ValueError(f"{dataset.path}: has no frames, expected some to look at")
    if only is not None and not 0 <= only <= last:
        raise ValueError(f"{dataset.path}: there is no episode {only}, expected 0 to {last}")


def _origin(episode: Episode) -> str:
    return f"iteration {episode.columns['source.iteration'][0, 0]}, {episode.task}"
