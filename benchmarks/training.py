"""Training of both policies, beside plain loops of the same networks and the machine's products."""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from time import time

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch.utils.flop_counter import FlopCounterMode

from benchmarks.timing import Row, paired, seconds
from pipeline.driving.features import CAMERA, IMAGE_SHAPE, IMITATED
from pipeline.driving.lesson import DrivingLesson
from pipeline.driving.network import PrimaryNetwork
from pipeline.learning.settings import Optimisation, SafetySettings
from pipeline.learning.training import train_primary, train_safety
from pipeline.policies.computing import CPU
from pipeline.policies.inference import propose
from pipeline.policies.network import has_bfloat16

FRAMES = 1280
EPISODES = 245  # of 40 frames each: D_3 of the default scale
EXAMPLES = 16 * FRAMES
PRODUCT = 2048
LESSON = DrivingLesson()
THREADS = 2


class PlainNetwork(PrimaryNetwork):
    """The same network as anyone would write it."""

    def features(self, images: Tensor, kind: torch.dtype | None = None) -> Tensor:
        """As the paper lists the layers, in PyTorch's default layout."""
        x = images * 2 - 1
        for convolution in self.convolutions()[:4]:
            x = F.max_pool2d(F.relu(convolution(x)), 2)
        return F.relu(self.conv5(x))


def rows() -> Iterator[Row]:
    """Speeds, ours above the floor's: a ratio of 2 is twice as fast."""
    torch.set_num_threads(THREADS)
    columns, episodes = _frames()
    kinds = [("float32", False, "at least 2")]
    if has_bfloat16(CPU):
        kinds.insert(0, ("bfloat16", True, "at least 4"))
    work = _operations(columns)
    for kind, bfloat16, target in kinds:
        told = Optimisation(samples=FRAMES, bfloat16=bfloat16, threads=THREADS)

        def ours(told: Optimisation = told) -> None:
            train_primary(LESSON, IMITATED, columns, episodes, told)

        yield _speed(
            f"training of the primary in {kind}, a plain fp32 loop of the same network",
            FRAMES,
            "images/s",
            paired(ours, lambda: _plain_primary(columns), 3),
            target,
        )
        yield _speed(
            f"the same, the machine's own product of matrices in {kind}",
            FRAMES * work / 1e9,
            "GFLOP/s",
            paired(ours, _product(FRAMES * work, getattr(torch, kind)), 3),
        )
    network = LESSON.network(IMITATED, columns, torch.Generator())
    yield _speed(
        "features of the primary for its safety policy, a plain fp32 pass",
        FRAMES,
        "images/s",
        paired(lambda: propose(network, columns), lambda: _plain_pass(columns), 3),
    )
    features = propose(network, columns)[1]
    safe = np.arange(FRAMES) % 4 != 0
    deviation = np.where(safe, 0.0, 1.0)
    settings = SafetySettings(samples=EXAMPLES, threads=THREADS)
    yield _speed(
        "training of the safety policy on them, a plain fp32 loop of the same network",
        EXAMPLES,
        "frames/s",
        paired(
            lambda: train_safety(features, deviation, episodes, settings),
            lambda: _plain_safety(features, safe),
            3,
        ),
    )
    yield start()


def start() -> Row:
    """A training's first batch of 9,800 frames, and what Python needs to import PyTorch."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        _command("collect", folder / "D", "--episodes", EPISODES, "--traffic", 0)
        curve = folder / "curve.csv"
        begun = time()
        _command(
            *("train-primary", folder / "D", folder / "primary"),
            *("--samples", Optimisation.batch, "--curve", curve),
        )
        first = curve.stat().st_mtime - begun  # written when the only batch is done
    torch_alone = seconds(lambda: _python("-c", "import torch"))
    what = "a training's start up to the first batch of 9,800 frames, `import torch`"
    return Row(what, first, torch_alone, "s", first / torch_alone)


def _frames() -> tuple[dict[str, np.ndarray], np.ndarray]:
    rng = np.random.default_rng(0)
    actions = np.stack([rng.normal(size=FRAMES) / 5, rng.random(FRAMES) < 0.1], 1)
    columns = {
        CAMERA: rng.integers(0, 256, (FRAMES, *IMAGE_SHAPE), np.uint8),
        "action": actions.astype(np.float32),
        "affordances": (rng.random((FRAMES, 10)) < 0.5).astype(np.float32),
    }
    return columns, np.arange(FRAMES) // 40


def _plain_primary(columns: dict[str, np.ndarray], frames: int = FRAMES) -> None:
    """An epoch without augmentation, which ours has."""
    network, batch = PlainNetwork(LESSON.channels), Optimisation.batch
    optimizer = torch.optim.AdamW(network.parameters())
    data = {name: torch.from_numpy(values) for name, values in columns.items()}
    for numbers in torch.randperm(frames).split(batch):
        shown = {name: values[numbers] for name, values in data.items()}
        images = shown[CAMERA].permute(0, 3, 1, 2).contiguous().float() / 255
        optimizer.zero_grad()
        loss, _ = LESSON.loss(network, network.features(images), shown)
        loss.backward()
        optimizer.step()


def _plain_pass(columns: dict[str, np.ndarray]) -> None:
    network = PlainNetwork(LESSON.channels)
    with torch.no_grad():
        for images in torch.from_numpy(columns[CAMERA]).split(Optimisation.batch):
            network.features(images.permute(0, 3, 1, 2).contiguous().float() / 255)


def _plain_safety(features: np.ndarray, safe: np.ndarray) -> None:
    hidden, size = SafetySettings.hidden, features.shape[1]
    layers = [nn.Linear(size, hidden), nn.ReLU(), nn.Linear(hidden, hidden), nn.ReLU()]
    network = nn.Sequential(*layers, nn.Linear(hidden, 2))
    optimizer = torch.optim.AdamW(network.parameters())
    seen, labels = torch.from_numpy(features), torch.from_numpy(safe).long()
    for _ in range(EXAMPLES // len(features)):
        for numbers in torch.randperm(len(features)).split(SafetySettings.batch):
            optimizer.zero_grad()
            F.cross_entropy(network(seen[numbers].float()), labels[numbers]).backward()
            optimizer.step()


def _operations(columns: dict[str, np.ndarray]) -> float:
    """Additions and multiplications that training takes of one image."""
    with FlopCounterMode(display=False) as counter:
        _plain_primary(columns, Optimisation.batch)
    return float(counter.get_total_flops()) / Optimisation.batch


def _product(operations: float, kind: torch.dtype) -> Callable[[], None]:
    """Products of square matrices, as many as make so many operations."""
    a, b = (torch.rand(PRODUCT, PRODUCT).to(kind) for _ in range(2))

    def multiply() -> None:
        for _ in range(round(operations / (2 * PRODUCT**3))):
            torch.mm(a, b)

    return multiply


def _speed(
    what: str, amount: float, unit: str, taken: tuple[float, float, float], target: str = ""
) -> Row:
    """A row of seconds that both took to do an amount."""
    ours, floor, ratio = taken
    return Row(what, amount / ours, amount / floor, unit, 1 / ratio, target)


def _command(*words: object) -> None:
    _python("-m", "stages", *words)


def _python(*words: object) -> None:
    subprocess.run([sys.executable, *map(str, words)], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    from benchmarks.timing import table

    print(table(rows()))
