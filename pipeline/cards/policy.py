"""What there is to say of a policy, read from its directory."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import Tensor

from pipeline.policies.loading import (
    SAFETY_TYPE,
    load_primary,
    load_safety,
    read_config,
)
from pipeline.registry import PRIMARIES


@dataclass(frozen=True)
class Part:
    """One layer of a network, or all of its outputs."""

    name: str
    shape: tuple[int, ...]
    """of the weights; empty for several layers"""
    parameters: int


@dataclass(frozen=True)
class PolicyFacts:
    """A policy: what it is, and by what numbers it works."""

    name: str
    kind: str
    """LeRobot's name for it"""
    config: Mapping[str, Any]
    parts: list[Part]

    @property
    def is_safety(self) -> bool:
        """Whether it is a safety policy."""
        return self.kind == SAFETY_TYPE

    @property
    def step(self) -> str:
        """What its name says after its kind: "0" of primary_0."""
        return self.name.partition("_")[2]

    @property
    def parameters(self) -> int:
        """Numbers that were trained."""
        return sum(part.parameters for part in self.parts)


def read_policy(path: Path) -> PolicyFacts:
    """Read a policy, and check that its weights are whole and fit.

    Raises:
        ValueError: files are missing, of another kind of policy, or do not fit.
    """
    config = read_config(path, *PRIMARIES, SAFETY_TYPE)
    load = load_safety if config.kind == SAFETY_TYPE else load_primary
    weights = load(path).state_dict()
    return PolicyFacts(path.name, config.kind, config.content, _parts(weights))


def _parts(weights: Mapping[str, Tensor]) -> list[Part]:
    parts: dict[str, Part] = {}
    for key, tensor in weights.items():
        outputs = key.startswith("outputs.")
        name = "outputs" if outputs else key.rpartition(".")[0]
        before = parts.get(name, Part(name, (), 0))
        shape = tuple(tensor.shape) if key.endswith("weight") and not outputs else before.shape
        parts[name] = Part(name, shape, before.parameters + tensor.numel())
    return list(parts.values())
