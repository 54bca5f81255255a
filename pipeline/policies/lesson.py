"""The seam to a learner: which network a primary is, and how it learns from a dataset's columns.

In the shapes, B is the batch.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from pipeline.data.schema import Feature
from pipeline.registry import LESSONS, find_subclass
from pipeline.settings import Settings

if TYPE_CHECKING:
    import torch
    from lerobot.policies.pretrained import PreTrainedPolicy
    from numpy.typing import NDArray
    from torch import Tensor

    from pipeline.policies.network import ConvNetwork


class Lesson(Settings, ABC):
    """A kind of primary with its settings. A subclass is a frozen dataclass, as a task is."""

    name: ClassVar[str]
    jitter: float
    """[0, 1), how far brightness, contrast and the three colours of an image are moved"""

    @abstractmethod
    def learned(self, features: Mapping[str, Feature]) -> Mapping[str, Feature]:
        """The columns that it learns from, of a dataset with these: what the primary sees, the action,
        further targets. ValueError where there is nothing that such a primary could see.
        """

    @abstractmethod
    def network(
        self,
        features: Mapping[str, Feature],
        columns: Mapping[str, NDArray],
        generator: torch.Generator,
    ) -> ConvNetwork:
        """A new network for what it has `learned`, the features of the `columns` [N, ...].

        `generator` draws its weights.
        """

    def augment(self, batch: dict[str, Tensor], generator: torch.Generator) -> dict[str, Tensor]:
        """The batch as it is to be learned from; images are uint8 [B, H, W, 3]."""
        return batch

    @abstractmethod
    def loss(
        self, network: ConvNetwork, looked: Tensor, batch: Mapping[str, Tensor]
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """The loss of a batch, and its unweighted parts by name; `looked` is what `look` gives."""

    @abstractmethod
    def policy(self, network: ConvNetwork) -> PreTrainedPolicy:
        """The network as LeRobot knows policies, to be saved; imports LeRobot."""


def load_lesson(name: str) -> type[Lesson]:
    """The kind of this name, one of LESSONS or "module:class"; ValueError where there is none."""
    found: type[Lesson] = find_subclass("policy", name, LESSONS, Lesson)
    return found
