"""What is to be seen of a dataset: all of its episodes, or its takeovers only."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes
from pipeline.data.schema import Episode
from pipeline.inspection.takeovers import JUDGED, Takeover, takeovers
from pipeline.rollout.judgement import Judgement, judgements


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
