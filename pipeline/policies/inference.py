"""Driving with trained networks, without LeRobot.

Plain PyTorch: quick to import in the processes that drive. In the shapes, N is the number of frames,
A of the numbers in an action and F of those that a safety policy reads.
"""

import copy
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Self

import numpy as np
import torch
from torch import Tensor

from pipeline.data.schema import Feature, check_features, column_dtype
from pipeline.policies.computing import CPU, computing
from pipeline.policies.loading import load_pair, load_primary
from pipeline.policies.network import Actor, SafetyNetwork, has_bfloat16

_PROPOSED = 32
"""Images at a time: more do not fit into a processor's cache."""


class Driver:
    """A primary policy and, where there is one, its safety policy, ready to drive one robot; ValueError where
    their sizes do not fit, or a chunk is shorter than `hold`. Whether the safety policy was trained on
    this very primary, `load` checks.

    It can be pickled. The networks are copies: training the originals further changes nothing here.
    They compute on the primary's device; what comes and goes is in the processor's memory.

    Args:
        hold: how many actions of a chunk are done, a frame each, before the next one is planned. The
            policies look at each frame nevertheless: the safety policy judges what is done there.
        bfloat16: whether the convolutions may compute in bfloat16, on processors that can.
    """

    def __init__(
        self,
        primary: Actor,
        safety: SafetyNetwork | None = None,
        *,
        hold: int = 1,
        bfloat16: bool = True,
    ) -> None:
        if hold < 1:
            raise ValueError(f"hold is {hold}, expected at least 1")
        if hold > primary.chunk:
            raise ValueError(
                f"hold is {hold}, expected at most {primary.chunk}: the chunk of this primary"
            )
        size = primary.feature_size
        if safety is not None and safety.in_features != size:
            raise ValueError(
                f"safety takes {safety.in_features} numbers, expected the {size} of this primary"
            )
        self.primary = _ready(primary, bfloat16)
        self.safety = copy.deepcopy(safety).eval().to(primary.device) if safety else None
        self.hold = hold
        self._planned: deque[Tensor] = deque()

    @classmethod
    def load(
        cls,
        primary: Path,
        safety: Path | None = None,
        *,
        hold: int = 1,
        device: torch.device = CPU,
    ) -> Self:
        """The policies saved in two directories, such as models/primary_0 and models/safety_0, to
        compute on `device`. ValueError where files are missing, of another kind of policy, or do not
        fit; where `safety` watches another primary; or as `Driver`.
        """
        if safety is None:
            return cls(load_primary(primary, device=device), hold=hold)
        return cls(*load_pair(primary, safety, device), hold=hold)

    def check_task(self, name: str, features: Mapping[str, Feature]) -> None:
        """Check that a task with these columns shows what the primary sees, and does what it does: a
        ValueError names the first column that does not fit, and both sides.
        """
        wanted = {**self.primary.seen, "action": self.primary.action}
        try:
            check_features(_in_memory(features), _in_memory(wanted))
        except ValueError as error:
            raise ValueError(f"task {name}: {error} by the primary") from None

    def reset(self) -> None:
        """Forget what it had planned: a drive begins, or somebody else has just moved the robot."""
        self._planned.clear()

    def act(self, seen: Mapping[str, np.ndarray]) -> tuple[np.ndarray, dict[str, float]]:
        """The primary's action float32 [A] for an observation by column, and what the policies say beside
        it: "safe_probability" [0, 1], where there is a safety policy. ValueError where a column is
        missing, or of another shape or type.
        """
        for name, feature in self.primary.seen.items():
            kind, found = column_dtype(feature), seen.get(name)
            if found is None or (found.dtype, found.shape) != (kind, feature["shape"]):
                what = "missing" if found is None else f"{found.dtype} {found.shape}"
                raise ValueError(f"{name} is {what}, expected {kind} {feature['shape']}")
        with torch.inference_mode():
            device = self.primary.device
            batch = {n: torch.tensor(seen[n])[None].to(device) for n in self.primary.seen}
            if self._planned:
                looked = self.primary.look(batch)
            else:
                looked, planned = self.primary.plan(batch, self.hold)
                self._planned.extend(planned[0])
            action = self._planned.popleft()
            signals = {}
            if self.safety is not None:
                safe = self.safety(self.primary.doing(looked, action[None])).softmax(1)[0, 1]
                signals["safe_probability"] = float(safe)
            return action.cpu().numpy(), signals


def propose(
    network: Actor, seen: Mapping[str, np.ndarray], *, bfloat16: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """What a primary proposes for many frames, float32 [N, A], and what it looked at, float16 [N, F], in
    one pass on its device. They are `seen` by column [N, ...], images as uint8 [N, H, W, 3]; for
    `bfloat16` see `Driver`.
    """
    ready = _ready(network, bfloat16)
    frames = len(next(iter(seen.values())))
    actions = np.empty((frames, *network.action["shape"]), np.float32)
    looked = np.empty((frames, network.feature_size), np.float16)
    with torch.inference_mode(), computing():
        for start in range(0, frames, _PROPOSED):
            rows = slice(start, start + _PROPOSED)
            batch = {n: torch.tensor(seen[n][rows]).to(network.device) for n in network.seen}
            features = ready.look(batch)
            actions[rows] = ready.act(features).cpu().numpy()
            looked[rows] = features.flatten(1).half().cpu().numpy()
    return actions, looked


def _in_memory(features: Mapping[str, Feature]) -> dict[str, Feature]:
    """Without what makes no difference to who drives: how pictures are stored, and names."""
    return {
        name: {"dtype": str(column_dtype(of)), "shape": tuple(of["shape"]), "names": None}
        for name, of in features.items()
    }


def _ready(network: Actor, bfloat16: bool) -> Actor:
    """A copy to infer with; converted once here, not at each image as autocast would."""
    ready = copy.deepcopy(network).eval().requires_grad_(False)
    if bfloat16 and has_bfloat16(network.device):
        for convolution in ready.convolutions():
            convolution.to(torch.bfloat16)
    return ready
