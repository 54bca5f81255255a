"""The way of a frame through datasets, beside the least that each step of it could take. A filter of
rows hashes nothing, counts no statistics, tells LeRobot nothing of the episodes and checks nothing.

python -m benchmarks.data
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import torch

from benchmarks.timing import Row, paired, shares, table
from pipeline.data.dataset import Dataset
from pipeline.data.images import read_all
from pipeline.data.lineage import Recipe
from pipeline.data.merging import merge
from pipeline.data.schema import Episode
from pipeline.data.selecting import sample, select
from pipeline.data.writing import write_dataset
from pipeline.driving.features import CAMERA, IMITATED
from pipeline.driving.task import Driving
from pipeline.driving.tracks import make_track
from pipeline.driving.world import World
from pipeline.policies.network import to_float
from pipeline.rollout.recording import record_all
from pipeline.rollout.rules.reference import Reference

TASK = Driving(tracks="alder,birch,cedar,hazel,larch", traffic=12)
DRIVES = 5  # of 200 frames
COPIES = 4
ASKED = 0.4  # share of the frames, in runs of 6 on average
BATCH = 32
SELECT = {
    "pipeline/data/pieces.py:stored_rows": "reading rows",
    "pipeline/data/content.py:add": "their hash",
    "pipeline/data/blocks.py:_write_rows": "writing them, in row groups of 32 or more",
    "pipeline/data/blocks.py:_write_metadata": "statistics, and what LeRobot keeps of each episode",
    "pipeline/data/dataset.py:open": "checking what was written",
}
"""What a filter of rows has none of, but for reading and writing."""


def rows() -> Iterator[Row]:
    """Times, ours and the floor's: a ratio of 1 is the floor."""
    recordings = record_all(
        TASK, Reference(), None, range(DRIVES), seed=(0,), iteration=0, workers=2, measure=False
    )
    drives = [recording.episode for recording in recordings]
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        yield _writing(drives, root)
        rng = np.random.default_rng(0)
        d_0 = _write(root / "D_0", drives, "D_0")
        driven = [_partly_asked(drives[n % DRIVES], n, rng) for n in range(COPIES * DRIVES)]
        rollout = _write(root / "rollout", driven, "rollout")
        select(rollout, root / "new")
        new = Dataset.open(root / "new")
        yield from _moving(d_0, rollout, new, root)
        again = _anew(root / "out", lambda path: select(rollout, path))
        yield from shares("of a select", again, SELECT)
        yield _tensors(rollout, root)
        merge([d_0, new], root / "D_1")
        yield from _starts(root)


def _writing(drives: Sequence[Episode], root: Path) -> Row:
    frames = sum(map(len, drives))

    def render() -> None:
        with World(make_track("alder"), 12, (0.0, 0.0), np.random.default_rng(0)) as world:
            for _ in range(frames):
                world.image()

    times = paired(_anew(root / "D", lambda path: _write(path, drives, "D_0")), render)
    return Row.timed("a frame written, and rendered", times, 1e3 / frames, "ms", "")


def _moving(d_0: Dataset, rollout: Dataset, new: Dataset, root: Path) -> Iterator[Row]:
    keep = np.zeros(len(rollout), bool)
    keep[np.random.default_rng(0).choice(len(keep), len(new), replace=False)] = True
    asked = rollout.column("queried")
    steps: dict[str, tuple[Callable[[Path], object], list[Dataset], np.ndarray]] = {
        "select": (lambda path: select(rollout, path), [rollout], asked),
        "sample": (lambda path: sample(rollout, path, len(new), 0), [rollout], keep),
        "merge": (
            lambda path: merge([d_0, new], path),
            [d_0, new],
            np.ones(len(d_0) + len(new), bool),
        ),
    }
    for name, (ours, parts, chosen) in steps.items():
        files = [file for part in parts for file in part.data_files]

        def floor(files: list[Path] = files, chosen: np.ndarray = chosen) -> None:
            there = pa.concat_tables([pq.ParquetFile(file).read() for file in files])
            pq.write_table(there.filter(pa.array(chosen)), root / "filtered.parquet")

        times = paired(_anew(root / "out", ours), floor)
        what = f"{name}: {chosen.sum()} of {len(chosen)} frames, and a row filter of the same files"
        yield Row.timed(what, times, 1, "s", "at most 3")


def _tensors(dataset: Dataset, root: Path) -> Row:
    import datasets
    from lerobot.datasets import LeRobotDataset
    from torch.utils.data import DataLoader

    datasets.config.HF_DATASETS_CACHE = root / "cache"
    datasets.disable_progress_bars()

    def ours() -> None:
        columns = read_all(Dataset.open(dataset.path), IMITATED)
        for numbers in torch.randperm(len(dataset)).split(BATCH):
            batch = {n: torch.from_numpy(values[numbers.numpy()]) for n, values in columns.items()}
            to_float(batch[CAMERA])

    def theirs() -> None:
        loaded = LeRobotDataset("local/driven", root=dataset.path, video_backend="pyav")
        for _ in DataLoader(loaded, BATCH, shuffle=True, num_workers=2):
            pass

    what = "a frame from the dataset to a batch, and by LeRobot's DataLoader with two workers"
    return Row.timed(what, paired(ours, theirs, 3), 1e3 / len(dataset), "ms", "at most 1")


def _starts(root: Path) -> Iterator[Row]:
    """Whole commands, on little: their start is most of it."""
    commands = {
        "select": "rollout out",
        "merge": "D_0 new out",
        "ledger": "rollout D_1 --metrics out",
        "collect": "out --task driving --tracks alder --episodes 1 --seconds 0.1 --workers 1",
    }
    for name, words in commands.items():

        def ours(path: Path, name: str = name, words: str = words) -> None:
            _python("-m", "stages", name, *words.split(), cwd=root)

        times = paired(
            _anew(root / "out", ours), lambda: _python("-c", "import lerobot.datasets"), 2
        )
        yield Row.timed(
            f"{name} as a command, and `import lerobot.datasets`", times, 1, "s", "below 1"
        )


def _write(path: Path, drives: Sequence[Episode], purpose: str) -> Dataset:
    write_dataset(path, drives, Recipe(purpose, {}), fps=TASK.fps, robot=TASK.robot)
    return Dataset.open(path)


def _partly_asked(drive: Episode, number: int, rng: np.random.Generator) -> Episode:
    """As a safety policy would have it: the reference drives now and then, for a while."""
    asked = np.zeros((len(drive), 1), bool)
    now = False
    for frame in range(len(drive)):
        now ^= rng.random() < (1 / 6 if now else ASKED / (1 - ASKED) / 6)
        asked[frame] = now
    known = {"intervention": asked, "queried": asked, "safe_probability": 1 - asked.astype("f4")}
    place = {"source.episode": np.full((len(drive), 1), number)}
    return replace(drive, columns=drive.columns | known | place)


def _anew(path: Path, write: Callable[[Path], object]) -> Callable[[], None]:
    """Write to `path`, whatever is there."""

    def run() -> None:
        if path.is_dir():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)
        write(path)

    return run


def _python(*words: str, cwd: Path | None = None) -> None:
    subprocess.run([sys.executable, *words], cwd=cwd, check=True, capture_output=True)


if __name__ == "__main__":
    print(table(rows()))
