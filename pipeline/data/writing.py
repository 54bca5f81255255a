"""Writing datasets with LeRobot: complete or not at all; equal episodes give equal bytes."""

import contextlib
import shutil
import sys
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.data.canonical import canonicalise
from pipeline.data.ledger import row_queries
from pipeline.data.reading import check_dataset, read_columns
from pipeline.data.schema import FEATURES, ROBOT_TYPE, Episode, check_record_every


@dataclass(frozen=True)
class Summary:
    """What a dataset holds."""

    path: Path
    episodes: int
    frames: int
    """Rows."""
    queries: int
    """Control frames for which the reference was asked; see `ledger.row_queries`."""


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

    Whatever is left where it does not, KeyboardInterrupt included, is removed, and so is the cache
    that `datasets` fills, which would otherwise stay in the user's home.

    Raises:
        FileExistsError: `path` exists; before the block is entered.
    """
    refuse_existing(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    # a sibling, so that the last step is a rename within one file system
    scratch = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        with _quiet_datasets(scratch / "cache"):
            yield scratch / "dataset"
        (scratch / "dataset").rename(path)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def refuse_existing(path: Path) -> None:
    """Raise FileExistsError if there is anything at `path`."""
    if path.exists() or path.is_symlink():
        raise FileExistsError(f"{path}: exists already, expected a new path")


def summarise(path: Path) -> Summary:
    """Count what a dataset holds, from its columns.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    record_every = check_dataset(path)
    columns = read_columns(path, ["intervention", "queried"])
    queries = row_queries(columns["intervention"], columns["queried"], record_every)
    index = columns["episode_index"]
    return Summary(path, int(index[-1]) + 1, len(index), int(queries.sum()))


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
