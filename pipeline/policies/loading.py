"""Saved policies, read without LeRobot: quick to import in the processes that drive."""

import hashlib
import json
from pathlib import Path
from types import UnionType
from typing import Any

from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from pipeline.data.lineage import Lineage
from pipeline.policies.network import PrimaryNetwork, SafetyNetwork, feature_size

CONFIG_FILE = "config.json"
WEIGHTS_FILE = "model.safetensors"
"""What a directory models/<policy>_<iteration> holds, with LeRobot's processors beside them."""

PRIMARY_TYPE = "safedagger_primary"
SAFETY_TYPE = "safedagger_safety"
"""LeRobot's names for the two kinds of policies."""


def load_primary(directory: Path) -> PrimaryNetwork:
    """The primary network in a policy's directory; ValueError where it is missing or misfits."""
    config = read_config(directory, PRIMARY_TYPE)
    network = PrimaryNetwork(_field(directory, config, "channels", int))
    load_weights(network, directory)
    return network


def load_safety(directory: Path) -> SafetyNetwork:
    """The safety network in a policy's directory; ValueError where it is missing or misfits."""
    config = read_config(directory, SAFETY_TYPE)
    channels, hidden = (_field(directory, config, name, int) for name in ("channels", "hidden"))
    network = SafetyNetwork(feature_size(channels), hidden)
    load_weights(network, directory)
    return network


def read_brake_cut(primary: Path) -> float:
    """The probability above which a primary brakes; ValueError where it is missing."""
    config = read_config(primary, PRIMARY_TYPE)
    return float(_field(primary, config, "brake_cut", int | float))


def read_config(directory: Path, kind: str) -> dict[str, Any]:
    """The configuration of the policy in `directory`.

    Raises:
        ValueError: there is none, it is not JSON, or not of this kind of policy.
    """
    path = Path(directory) / CONFIG_FILE
    try:
        config = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}, expected a saved {kind} policy") from None
    except ValueError as error:
        raise ValueError(f"{path}: not JSON ({error}), expected a saved {kind} policy") from None
    found = config.get("type") if isinstance(config, dict) else None
    if found != kind:
        raise ValueError(f"{path}: the policy's type is {found!r}, expected {kind!r}")
    return config


def weights_sha256(directory: Path) -> str:
    """The SHA-256 of a policy's weights file, in hexadecimal: which policy it is.

    Raises:
        ValueError: the file is missing.
    """
    with open(_weights(directory), "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def policy_lineage(directory: Path) -> Lineage:
    """What the policy in `directory` is and comes from; foreign where somebody else has trained it.

    Raises:
        ValueError: there are no weights, or what tells is not one of our files.
    """
    sha256 = weights_sha256(directory)
    known = Lineage.read(Path(directory))
    return known if known and known.sha256 == sha256 else Lineage.foreign(sha256)


LABELS = ("tau", "include_brake", "horizon", "horizon_mode")
"""What a safety policy's configuration says of the labels that it learned."""


def read_labels(safety: Path) -> dict[str, Any]:
    """By what rule the labels of the safety policy in `safety` were made; raises as `read_config`."""
    config = read_config(safety, SAFETY_TYPE)
    return {name: config[name] for name in LABELS}


def read_cut(safety: Path) -> float:
    """The safe probability below which the policy in `safety` says unsafe; raises as `read_config`."""
    return float(_field(safety, read_config(safety, SAFETY_TYPE), "cut", int | float))


def load_weights(network: nn.Module, directory: Path) -> None:
    """Fill `network` with the weights saved in `directory`: all of them, and no others.

    Raises:
        ValueError: the file is missing or damaged, or a name, shape or type does not fit.
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


def check_pair(primary: Path, safety: Path) -> None:
    """Check that one policy watches the other: Conv5 of another primary means something else.

    Raises:
        ValueError: it was trained on another primary; or as `read_config`.
    """
    config = read_config(safety, SAFETY_TYPE)
    known = _field(safety, config, "primary_sha256", str)
    if known != weights_sha256(primary):
        raise ValueError(f"{safety}: was trained to watch another primary than {primary}")


def _weights(directory: Path) -> Path:
    path = Path(directory) / WEIGHTS_FILE
    if not path.is_file():
        raise ValueError(f"{path} is missing, expected the weights of a policy")
    return path


def _describe(weights: Tensor | None) -> str:
    return "none" if weights is None else f"{weights.dtype} {list(weights.shape)}"


def _field(directory: Path, config: dict[str, Any], name: str, kind: type | UnionType) -> Any:
    if not isinstance(config.get(name), kind):
        path, expected = Path(directory) / CONFIG_FILE, "text" if kind is str else "a number"
        raise ValueError(f"{path}: {name} is {config.get(name)!r}, expected {expected}")
    return config[name]
