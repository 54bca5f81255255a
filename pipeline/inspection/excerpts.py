"""What is to be seen of a dataset: all of its episodes, or its takeovers only."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.data.reading import check_dataset, read_columns, read_episodes
from pipeline.data.schema import CONTROL_HZ, Episode
from pipeline.inspection.takeovers import Takeover, takeovers


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

    def __len__(self) -> int:
        return len(self.episode)


def whole_episodes(path: Path, only: int | None = None) -> Iterator[Excerpt]:
    """Every episode of a dataset, or `only` one of them; in order, and read one at a time.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`, or there is no such episode; at once.
    """
    _check_episode(path, only)
    return (
        Excerpt(f"episode {i:04d}: {_origin(episode)}", f"{path.name}/episode_{i:04d}", episode, 0)
        for i, episode in enumerate(read_episodes(path))
        if only in (None, i)
    )


def around_takeovers(path: Path, only: int | None = None) -> Iterator[Excerpt]:
    """The window around every takeover of all episodes or of `only` one, read one at a time.

    Their titles rank them, the most unsafe is the first. That one comes last, where a viewer stays;
    the others come in the order of the dataset: to have their images in order, all of them would
    have to be in memory.

    Raises:
        FileNotFoundError, ValueError: as `whole_episodes`, or there is no takeover; at once.
    """
    _check_episode(path, only)
    columns = read_columns(path, ["intervention", "safe_probability"])
    chosen = [
        takeover
        for takeover in takeovers(
            columns["intervention"][:, 0],
            columns["safe_probability"][:, 0],
            columns["episode_index"],
            fps=CONTROL_HZ // check_dataset(path),
        )
        if only in (None, takeover.episode)
    ]
    if not chosen:
        where = path if only is None else f"{path}: episode {only}"
        raise ValueError(f"{where} has no takeovers, expected some of a safety policy's")
    return _windows(path, chosen)


def _windows(path: Path, ranked: list[Takeover]) -> Iterator[Excerpt]:
    """As `around_takeovers` has them; `ranked` is most unsafe first."""
    of_episode: dict[int, list[tuple[int, Takeover]]] = {}
    for rank, takeover in enumerate(ranked, 1):
        of_episode.setdefault(takeover.episode, []).append((rank, takeover))
    first: list[Excerpt] = []
    for i, episode in enumerate(read_episodes(path)):
        for rank, takeover in of_episode.get(i, []):
            excerpt = Excerpt(
                f"takeover {rank:04d}: safe probability {takeover.safe_probability:.3f}, episode "
                f"{i}, frame {takeover.start}, {_origin(episode)}",
                f"{path.name}/takeover_{rank:04d}",
                episode.rows(takeover.first, takeover.end),
                takeover.first,
            )
            if rank == 1:
                first.append(excerpt)
            else:
                yield excerpt
    yield from first


def _check_episode(path: Path, only: int | None) -> None:
    last = int(read_columns(path, ["queried"])["episode_index"][-1])
    if only is not None and not 0 <= only <= last:
        raise ValueError(f"{path}: there is no episode {only}, expected 0 to {last}")


def _origin(episode: Episode) -> str:
    return f"iteration {episode.columns['source.iteration'][0, 0]}, {episode.task}"
