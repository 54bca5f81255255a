"""What all stages that drive have in common: every frame into a dataset, with progress."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from stages import options

if TYPE_CHECKING:
    from pipeline.data.lineage import Recipe
    from pipeline.data.schema import Episode
    from pipeline.rollout.recording import Recording


def keep(
    recordings: Iterable["Recording"],
    output: Path,
    recipe: "Recipe",
    task: options.Task,
    *,
    what: str,
    total: int,
    count: Callable[["Recording"], int] = lambda drive: drive.queries,
) -> str:
    """Write drives of a task as they are ready; says what there is then, and why they ended.

    Progress is shown as a `total` of `what`, of which each drive is a `count`.
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
