"""Two drives of the same task, to be seen side by side."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from pipeline.data.dataset import Dataset
from pipeline.inspection.excerpts import Excerpt, ending, whole_episodes


@dataclass(frozen=True, eq=False)
class Pair:
    """Two drives of one task."""

    title: str
    name: str
    """A short one, of this pair only."""
    a: Excerpt
    b: Excerpt


def pairs(
    a: Dataset, b: Dataset, number: int = 0, *, place: Callable[[str], str] = str
) -> Iterator[Pair]:
    """Of two datasets: a pair for every task that both have, in the order of `a`, read one at a time.

    `number` is which of the drives of a task, 0 the first. Tasks are the same where `place` makes the
    same of their words. ValueError, at once, for other frame rates or another robot's, and where there
    are no such drives of any task.
    """
    b.require_robot_of(a)
    of_a, of_b = (_of_each_task(dataset, number, place) for dataset in (a, b))
    both = [task for task in of_a if task in of_b]
    if not both:
        raise ValueError(f"{a.path} and {b.path} have no drive {number} of a task that is in both")
    return (_pair(task, (a, of_a[task]), (b, of_b[task])) for task in both)


Which = tuple[Dataset, int]
"""A dataset, and the number of one of its episodes."""


def _pair(task: str, a: Which, b: Which) -> Pair:
    (of_a, i), (of_b, j) = a, b
    return Pair(
        f"{task}: a is {of_a.path.name}, episode {i}{ending(of_a, i)}; "
        f"b is {of_b.path.name}, episode {j}{ending(of_b, j)}",
        f"{task}/{of_a.path.name}_{i}/{of_b.path.name}_{j}",
        next(whole_episodes(of_a, i)),
        next(whole_episodes(of_b, j)),
    )


def _of_each_task(dataset: Dataset, number: int, place: Callable[[str], str]) -> dict[str, int]:
    """By task: which episode is its drive of that number."""
    found: dict[str, int] = {}
    before: Counter[str] = Counter()
    for episode, task in enumerate(map(place, dataset.tasks)):
        if before[task] == number:
            found[task] = episode
        before[task] += 1
    return found
