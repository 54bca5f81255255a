"""Writing datasets with LeRobot: complete or not at all; equal episodes give equal bytes."""

import contextlib
import sys
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.data.canonical import canonicalise
from pipeline.data.reading import read_columns
from pipeline.data.schema import FEATURES, ROBOT_TYPE, Episode, check_record_every
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

    def __str__(self) -> str:
        counts = f"{self.episodes} episodes, {self.frames} frames, {self.queries} queries"
        return f"{self.path}: {counts}"


def write_dataset(path: Path, episodes: Iterable[Episode], *, record_every: int) -> Summary:
    """Write `episodes` as a LeRobot dataset.

    Args:
        path: must not exist.
        episodes: consumed one at a time.
        record_every: control frames that each row stands for, a divisor of 30; fps is 30 / this.

    Raises:
        FileExistsError: `path` exists; before the first episode is asked for.
        ValueError: `record_every` does not divide 30, or there are no episodes.
    """
    fps = check_record_every(record_every)
    with new_dataset(path) as root:
        _record(root, episodes, fps)
        canonicalise(root)
    return summarise(path)


@contextlib.contextmanager
def new_dataset(path: Path) -> Iterator[Path]:
    """A path to build a dataset at, which becomes `path` where the block ends well.

    Whatever is left where it does not is removed, and so is the cache that `datasets` fills, which
    would otherwise stay in the user's home.

    Raises:
        FileExistsError: `path` exists; before the block is entered.
    """
    with new_directory(path) as root, _quiet_datasets(root.parent / "cache"):
        yield root


def summarise(path: Path) -> Summary:
    """Count what a dataset holds, from its columns.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    columns = read_columns(path, ["queried"])
    index = columns["episode_index"]
    return Summary(path, int(index[-1]) + 1, len(index), int(columns["queried"].sum()))


def _record(root: Path, episodes: Iterable[Episode], fps: int) -> None:
    from lerobot.datasets import LeRobotDataset

    dataset = LeRobotDataset.create(
        "local/dataset",
        fps=fps,
        features=FEATURES,
        root=root,
        robot_type=ROBOT_TYPE,
        use_videos=False,
        video_backend="pyav",
        # compressing PNG is a third of the work, and happens outside the GIL
        image_writer_threads=2,
        # All at the end: LeRobot takes the types of the statistics from the first that it writes,
        # and those of one-row episodes are flags and whole numbers where others are not.
        metadata_buffer_size=sys.maxsize,
    )
    recorded = 0
    try:
        for episode in episodes:
            for row in range(len(episode)):
                frame = {name: values[row] for name, values in episode.columns.items()}
                dataset.add_frame({**frame, "task": episode.task})
            with warnings.catch_warnings():
                # NaN has no minimum; canonicalise() looks after the statistics
                warnings.simplefilter("ignore", RuntimeWarning)
                dataset.save_episode()
            recorded += 1
        dataset.finalize()
    except BaseException:
        # else the garbage collector does it, and brings back the directory that was removed
        with contextlib.suppress(Exception):
            dataset.finalize()
        raise
    if recorded == 0:
        raise ValueError("there are no episodes, expected at least one frame")


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
