"""Algorithm 1, line 8: aggregate datasets into one, with LeRobot."""

import contextlib
import io
import logging
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

from pipeline.data.canonical import canonicalise
from pipeline.data.identity import refuse_shared
from pipeline.data.reading import check_dataset
from pipeline.data.schema import CONTROL_HZ
from pipeline.data.writing import Summary, new_dataset, summarise
from pipeline.output import refuse_existing


def merge(paths: Sequence[Path], output: Path) -> Summary:
    """Write the episodes of the datasets `paths`, in that order, as the dataset `output`.

    Args:
        paths: at least one, all of the same frame rate, and no frame in two of them.
        output: must not exist.

    Raises:
        FileExistsError: `output` exists.
        FileNotFoundError: one of `paths` does not exist.
        ValueError: one is no complete dataset of our schema, they differ in frame rate or share a
            frame, or there are none.
    """
    refuse_existing(output)
    if not paths:
        raise ValueError("there are no datasets to merge, expected at least one path")
    fps = [CONTROL_HZ // check_dataset(path) for path in paths]
    for path, found in zip(paths, fps, strict=True):
        if found != fps[0]:
            raise ValueError(f"{path}: fps is {found}, expected {fps[0]} as in {paths[0]}")
    for first, second in combinations(paths, 2):
        refuse_shared(first, second)
    with new_dataset(output) as root:
        _merge_with_lerobot(paths, root)
        canonicalise(root)
    return summarise(output)


def _merge_with_lerobot(paths: Sequence[Path], root: Path) -> None:
    from lerobot.datasets import LeRobotDataset, merge_datasets

    with _silence():
        merge_datasets(
            [LeRobotDataset("local/part", root=path, video_backend="pyav") for path in paths],
            "local/merged",
            output_dir=root,
            # One file for each input file: quicker, and the files of D_{i-1} stay byte for byte
            # what they were, so that DVC stores them once.
            concatenate_data=False,
        )


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Hide LeRobot's progress bars, and the traceback that it logs where there is no ffmpeg."""
    logger = logging.getLogger("lerobot")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            yield
    finally:
        logger.setLevel(level)
