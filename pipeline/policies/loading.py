"""Saved policies, read without LeRobot: quick to import in the processes that drive."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from pipeline.data.lineage import Lineage
from pipeline.data.schema import Feature
from pipeline.policies.computing import CPU
from pipeline.policies.network import Actor, ConvNetwork, SafetyNetwork
from pipeline.registry import PRIMARIES, find

CONFIG_FILE = "config.json"
WEIGHTS_FILE = "model.safetensors"
"""What a directory models/<policy>_<iteration> holds, with LeRobot's processors beside them."""

PRIMARY_TYPE = "safedagger_primary"
SAFETY_TYPE = "safedagger_safety"
CONV_TYPE = "safedagger_conv"
"""LeRobot's names for our kinds of policies."""

LABELS = ("tau", "measure", "half_range", "horizon", "horizon_mode")
"""What a safety policy's configuration says of the labels that it learned."""


@dataclass(frozen=True)
class Config:
    """The configuration of a saved policy."""

    path: Path
    kind: str
    """LeRobot's name for it."""
    content: dict[str, Any]

    def number(self, name: str) -> Any:
        """The number of this name; ValueError where there is none."""
        return self._field(name, int | float, "a number")

    def text(self, name: str) -> str:
        """The text of this name; ValueError where there is none."""
        found: str = self._field(name, str, "text")
        return found

    def _field(self, name: str, kind: type | UnionType, expected: str) -> Any:
        found = self.content.get(name)
        if not isinstance(found, kind) or isinstance(found, bool):
            raise ValueError(f"{self.path}: {name} is {found!r}, expected {expected}")
        return found


def load_primary(
    directory: Path, features_of: str | None = None, device: torch.device = CPU
) -> Actor:
    """The primary in a policy's directory: ours, or whatever LeRobot's registry knows, with processors.

    Of LeRobot's, `features_of` is the module whose input a safety policy reads, if any; see `lerobot`.
    ValueError where something is missing or misfits.
    """
    config = read_config(directory)
    if config.kind not in PRIMARIES:
        from pipeline.policies.lerobot import LeRobotActor  # imports LeRobot

        return LeRobotActor.load(directory, features_of, device)
    network: ConvNetwork = find("policy", config.kind, PRIMARIES).of(config)
    load_weights(network, directory)
    return network.to(device)


def load_safety(directory: Path) -> SafetyNetwork:
    """The safety network in a policy's directory; ValueError where it is missing or misfits."""
    config = read_config(directory, SAFETY_TYPE)
    network = SafetyNetwork(config.number("features"), config.number("hidden"))
    load_weights(network, directory)
    return network


def load_pair(
    primary: Path, safety: Path, device: torch.device = CPU
) -> tuple[Actor, SafetyNetwork]:
    """A primary on a device and the safety network that watches it. ValueError where that was trained on
    another primary, whose features mean something else; or as `load_primary`.
    """
    config = read_config(safety, SAFETY_TYPE)
    if config.text("primary_sha256") != weights_sha256(primary):
        raise ValueError(f"{safety}: was trained to watch another primary than {primary}")
    return load_primary(primary, config.text("features_of"), device), load_safety(safety)


def read_config(directory: Path, *kinds: str) -> Config:
    """The configuration of the policy in `directory`, of any of `kinds`, or of any at all; ValueError
    where there is none, it is not JSON, or of none of these kinds of policy.
    """
    path, wanted = Path(directory) / CONFIG_FILE, " or ".join(kinds or ("LeRobot",))
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}, expected a saved {wanted} policy") from None
    except ValueError as error:
        raise ValueError(f"{path}: not JSON ({error}), expected a saved {wanted} policy") from None
    found = content.get("type") if isinstance(content, dict) else None
    if not isinstance(found, str) or (kinds and found not in kinds):
        expected = " or ".join(map(repr, kinds)) or "a name"
        raise ValueError(f"{path}: the policy's type is {found!r}, expected {expected}")
    return Config(path, found, content)


def weights_sha256(directory: Path) -> str:
    """The SHA-256 of a policy's weights file, in hexadecimal: which policy it is; ValueError without one."""
    with open(_weights(directory), "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def policy_lineage(directory: Path) -> Lineage:
    """What the policy in `directory` is and comes from; foreign where somebody else has trained it.
    ValueError where there are no weights, or what tells is not one of our files.
    """
    sha256 = weights_sha256(directory)
    known = Lineage.read(Path(directory))
    return known if known and known.sha256 == sha256 else Lineage.foreign(sha256)


def begun_with(primary: Path) -> str:
    """The SHA-256 of the first primary in all that the one in a directory comes from: it is what the loop
    began with, whether it was trained on or only drove what was learned from.
    Raises as `policy_lineage`.
    """
    first = _first_primaries(policy_lineage(primary), {})
    return "+".join(sorted(first)) or weights_sha256(primary)


def _first_primaries(lineage: Lineage, known: dict[str, set[str]]) -> set[str]:
    """Those of `known` lineages, by their SHA-256, are looked for once: each is what many come from."""
    if lineage.sha256 not in known:
        before = set[str]().union(*(_first_primaries(each, known) for each in lineage.parents))
        own = {lineage.sha256} if lineage.own.purpose == "primary" else set[str]()
        known[lineage.sha256] = before or own
    return known[lineage.sha256]


def read_labels(safety: Path) -> dict[str, Any]:
    """By what rule the labels of the safety policy in `safety` were made; raises as `read_config`."""
    config = read_config(safety, SAFETY_TYPE)
    missing = [name for name in LABELS if name not in config.content]
    if missing:
        raise ValueError(f"{config.path}: {missing[0]} is missing, expected what labels it learned")
    return {name: config.content[name] for name in LABELS}


def read_cut(safety: Path) -> float:
    """The safe probability below which the policy in `safety` says unsafe; raises as `read_config`."""
    return float(read_config(safety, SAFETY_TYPE).number("cut"))


def load_weights(network: nn.Module, directory: Path) -> None:
    """Fill `network` with the weights saved in `directory`: all of them, and no others. ValueError where
    the file is missing or damaged, or a name, shape or type does not fit.
    """
    path = _weights(directory)
    try:
        saved = load_file(path)
    except SafetensorError as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"{path}: {reason}, expected the weights of a policy") from None
    wanted = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    for name in sorted(wanted.keys() | saved.keys()):
        found, expected = (_describe(weights.get(name)) for weights in (saved, wanted))
        if found != expected:
            raise ValueError(f"{path}: {name} is {found}, expected {expected}")
    network.load_state_dict({name.removeprefix("network."): saved[name] for name in saved})


def _weights(directory: Path) -> Path:
    path = Path(directory) / WEIGHTS_FILE
    if not path.is_file():
        raise ValueError(f"{path} is missing, expected the weights of a policy")
    return path


def _describe(weights: Tensor | None) -> str:
    return "none" if weights is None else f"{weights.dtype} {list(weights.shape)}"


def feature(kind: str, shape: Iterable[int]) -> Feature:
    """A column as a policy's configuration has it: pictures with the channels first, and no names."""
    first, *others = shape
    if kind == "VISUAL":
        return {"dtype": "image", "shape": (*others, first), "names": None}
    return {"dtype": "float32", "shape": (first, *others), "names": None}
