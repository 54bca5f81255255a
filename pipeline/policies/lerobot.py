"""Any policy of LeRobot's as a primary: from its registry, with its processors.

It looks at each frame by itself, so only policies that need no history can drive: ACT can, diffusion
cannot. Of the chunk that it predicts, the first action is what it does now; whoever holds the others
for the frames to come does so by `plan`. B is the batch.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, Self

import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import get_policy_class, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from torch import Tensor, nn

from pipeline.data.schema import pictures
from pipeline.policies.computing import CPU
from pipeline.policies.loading import feature
from pipeline.policies.network import Actor, to_float

FEATURES_OF = {"act": "model.action_head"}
"""By LeRobot's type: the module whose input a safety policy reads, if it is not named."""


class LeRobotActor(Actor):
    """A policy that needs no history, its processors, and the module from which a safety policy learns.

    What a safety policy reads is that module's input for the first action, and the action itself;
    where `features_of` is "name:output", and not only its name, its output; where it is None, the action
    alone. ValueError where the policy has no such module.
    """

    def __init__(
        self, policy: PreTrainedPolicy, processors: tuple[Any, Any], features_of: str | None
    ) -> None:
        super().__init__()
        modules = dict(policy.named_modules())
        name, _, end = (features_of or "").partition(":")
        if name not in modules or end not in ("", "output"):
            raise ValueError(
                f"features_of is {features_of!r}, expected a module of {policy.name}, such as "
                f"{', '.join(name for name in list(modules)[1:4])}"
            )
        self.policy, self.features_of = policy, features_of
        self._before, self._after = processors
        inputs, outputs = policy.config.input_features or {}, policy.config.output_features or {}
        self.seen = {name: feature(of.type.name, of.shape) for name, of in inputs.items()}
        self.action = feature("ACTION", outputs["action"].shape)
        self._numbers = int(self.action["shape"][0])
        empty = {n: torch.zeros(1, *of["shape"], device=self.device) for n, of in self.seen.items()}
        for name in pictures(self.seen):
            empty[name] = empty[name].to(torch.uint8)
        features, chunk = self._predict(empty)
        self.feature_size, self.chunk = features.shape[1] + self._numbers, chunk.shape[1]

    @classmethod
    def load(
        cls, directory: Path, features_of: str | None = None, device: torch.device = CPU
    ) -> Self:
        """The policy saved in a directory, on a device, whichever it was trained on; `features_of` is ""
        for the module that is known of its type, None where no safety policy reads any. ValueError where
        LeRobot knows no such type, files are missing or do not fit, it needs a history, or nobody says
        which module a safety policy is to read.
        """
        try:
            config = PreTrainedConfig.from_pretrained(directory)
            config.device = str(device)
            with redirect_stdout(None):  # it prints that it loads
                policy = get_policy_class(config.type).from_pretrained(directory, config=config)
            processors = make_pre_post_processors(
                config,
                pretrained_path=str(directory),
                preprocessor_overrides={"device_processor": {"device": config.device}},
            )
        except Exception as error:  # LeRobot raises many kinds
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise ValueError(f"{directory}: {reason}, expected a policy of LeRobot's") from None
        module = features_of or FEATURES_OF.get(config.type)
        if module is None and features_of is not None:
            raise ValueError(
                f"{directory}: nobody says which module of a {config.type} a safety policy reads, "
                "expected --features-of"
            )
        try:
            return cls(policy.eval(), processors, module)
        except (RuntimeError, NotImplementedError, KeyError, IndexError) as error:
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise ValueError(
                f"{directory}: a {config.type} cannot act on one frame alone ({reason}), "
                "expected a policy that needs no history"
            ) from None

    def look(self, seen: Mapping[str, Tensor]) -> Tensor:
        """[B, F + A]: what the module takes, or gives, for the first action, and that action."""
        return self.plan(seen, 1)[0]

    @torch.no_grad()
    def plan(self, seen: Mapping[str, Tensor], length: int) -> tuple[Tensor, Tensor]:
        """The result of `look`, and the first actions of the chunk, [B, length, A]."""
        features, chunk = self._predict(seen)
        # one by one, as LeRobot does: a processor expects actions [B, A]
        actions = [self._after(chunk[:, n]).float().to(features.device) for n in range(length)]
        return torch.cat([features, actions[0]], 1), torch.stack(actions, 1)

    def doing(self, looked: Tensor, action: Tensor) -> Tensor:
        """With this action in the place of the first."""
        return torch.cat([looked[:, : -self._numbers], action], 1)

    @torch.no_grad()
    def _predict(self, seen: Mapping[str, Tensor]) -> tuple[Tensor, Tensor]:
        """What is read of the module for the first action, [B, F], and the chunk as the policy gives it."""
        images = pictures(self.seen)
        batch = {n: to_float(seen[n]) if n in images else seen[n].float() for n in self.seen}
        read: list[Tensor] = []
        if self.features_of is None:
            chunk = self.policy.predict_action_chunk(self._before(batch))
            return chunk.new_empty((len(chunk), 0), dtype=torch.float32), chunk
        name, _, end = self.features_of.partition(":")
        module: nn.Module = self.policy.get_submodule(name)
        hook = (
            module.register_forward_hook(lambda _, given, found: read.append(found))
            if end
            else module.register_forward_pre_hook(lambda _, given: read.append(given[0]))
        )
        try:
            chunk = self.policy.predict_action_chunk(self._before(batch))
        finally:
            hook.remove()
        if not read or not isinstance(read[-1], Tensor):
            kind = type(read[-1]).__name__ if read else "nothing"
            raise ValueError(
                f"features_of is {self.features_of!r}, where there is {kind}, expected a tensor"
            )
        features = read[-1][:, 0] if read[-1].ndim == 3 else read[-1].flatten(1)
        return features.float(), chunk

    def act(self, looked: Tensor) -> Tensor:
        """[B, A], the last of what was looked at."""
        return looked[:, -self._numbers :]
