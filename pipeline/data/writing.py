"""Recording datasets with LeRobot: complete or not at all; equal episodes give equal bytes."""

import contextlib
import csv
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.data.assembling import assemble
from pipeline.data.dataset import DRIVES, Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.pieces import whole
from pipeline.data.schema import Episode
from pipeline.output import new_directory


@dataclass(frozen=True)
class Summary:
    """What a dataset holds."""

    path: Path
    episodes: int
    frames: int
    """Rows."""
    queries: int
    """Frames for which the reference was asked."""

    @classmethod
    def of(cls, dataset: Dataset) -> "Summary":
        """Count it, from its columns."""
        queries = int(dataset.column("queried").sum())
        return cls(dataset.path, len(dataset.lengths), len(dataset), queries)

    def __str__(self) -> str:
        counts = f"{self.episodes} episodes, {self.frames} frames, {self.queries} queries"
        return f"{self.path}: {counts}"


def write_dataset(
    path: Path, episodes: Iterable[Episode], recipe: Recipe, *, fps: int, robot: str
) -> Summary:
    """Write `episodes` as a LeRobot dataset, and beside it how their drives ended.

    Args:
        path: must not exist.
        episodes: of the same features; consumed one at a time.
        recipe: what the dataset is and comes from.
        fps: frames per second.
        robot: LeRobot's `robot_type`.

    Raises:
        FileExistsError: `path` exists; before the first episode is asked for.
        ValueError: there are no episodes.
    """
    with new_directory(path) as root:
        recorded = root.parent / "recorded"
        with _quiet_datasets(root.parent / "cache"), _missed(recorded):
            endings = _record(recorded, episodes, fps, robot)
        dataset = Dataset.open(recorded)
        assemble(root, whole(dataset), recipe, like=dataset, features=dataset.features)
        _write_endings(root / DRIVES, endings)
    return Summary.of(Dataset.open(path))


def _record(
    root: Path, episodes: Iterable[Episode], fps: int, robot: str
) -> list[Mapping[str, Any]]:
    """Record with LeRobot; returns the endings of the drives."""
    from lerobot.datasets import LeRobotDataset

    dataset: LeRobotDataset | None = None
    endings = []
    try:
        for episode in episodes:
            if dataset is None:
                dataset = _new(root, episode, fps, robot)
            for row in range(len(episode)):
                frame = {name: values[row] for name, values in episode.columns.items()}
                dataset.add_frame({**frame, "task": episode.task})
            with warnings.catch_warnings():
                # NaN has no minimum; `assemble` looks after the statistics
                warnings.simplefilter("ignore", RuntimeWarning)
                dataset.save_episode()
            if episode.ending is not None:
                endings.append(episode.ending)
        if dataset is None:
            raise ValueError("there are no episodes, expected at least one frame")
        dataset.finalize()
    except BaseException:
        if dataset is not None:
            with contextlib.suppress(Exception):
                dataset.finalize()
            # else the garbage collector tries again, and brings back the directory that was removed
            for part in (dataset.writer, dataset.meta):
                part._finalized = True
        raise
    return endings


def _new(root: Path, episode: Episode, fps: int, robot: str) -> Any:
    from lerobot.datasets import LeRobotDataset

    return LeRobotDataset.create(
        "local/dataset",
        fps=fps,
        features=dict(episode.features),
        root=root,
        robot_type=robot,
        use_videos=False,
        video_backend="pyav",
        # compressing PNG is a third of the work, and happens outside the GIL
        image_writer_threads=2,
        # All at the end: LeRobot takes the types of the statistics from the first that it writes,
        # and those of one-row episodes are flags and whole numbers where others are not.
        metadata_buffer_size=sys.maxsize,
    )


def _write_endings(file: Path, endings: list[Mapping[str, Any]]) -> None:
    if endings:
        with open(file, "w", newline="", encoding="utf-8") as csv_file:
            table = csv.DictWriter(csv_file, list(endings[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(endings)


@contextlib.contextmanager
def _missed(root: Path) -> Iterator[None]:
    """Say what it means that a picture is missing: LeRobot's threads log only what they could not
    write.
    """
    try:
        yield
    except FileNotFoundError as error:
        if error.filename and Path(error.filename).is_relative_to(root):
            raise OSError(f"{error.filename} could not be written, is the disk full?") from None
        raise


@contextlib.contextmanager
def _quiet_datasets(cache: Path) -> Iterator[None]:
    """Have `datasets` show no progress, and keep its copies of what it opens in `cache`."""
    import datasets

    bars_shown = not datasets.are_progress_bars_disabled()
    cache_before = datasets.config.HF_DATASETS_CACHE
    datasets.disable_progress_bars()
    datasets.config.HF_DATASETS_CACHE = cache
    try:
        yield
    finally:
        datasets.config.HF_DATASETS_CACHE = cache_before
        if bars_shown:
            datasets.enable_progress_bars()
