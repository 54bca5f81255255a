"""What all stages that drive have in common: every frame into a dataset, with progress."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from stages import options

if TYPE_CHECKING:
    from pipeline.data.lineage import Recipe
    from pipeline.data.schema import Episode
    from pipeline.rollout.recording import Recording
    from pipeline.task import Task


def keep(
    recordings: Iterable["Recording"],
    output: Path,
    recipe: "Recipe",
    task: "Task",
    *,
    what: str,
    total: int,
    count: Callable[["Recording"], int],
) -> str:
    """Write drives as they are ready; says what there is then, and why they ended.

    Args:
        recordings: drives of the task.
        output: of the dataset.
        recipe: how it is made.
        task: what is driven.
        what: is counted to show progress.
        total: of that.
        count: how much of that a drive is.
    """
    from pipeline.data.writing import write_dataset

    ended: list[str] = []

    def episodes() -> Iterator["Episode"]:
        done = 0
        with options.progress(what, total) as advance_to:
            for recording in recordings:
                yield recording.episode
                ended.append(recording.ended)
                done += count(recording)
                advance_to(done)

    summary = write_dataset(output, episodes(), recipe, fps=task.fps, robot=task.robot)
    return f"{summary}; {options.endings(ended)}"
