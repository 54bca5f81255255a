"""Where a dataset or a policy comes from: the stage that made it, as dvc.lock has it."""

import os
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

_WIDTH = 96


@dataclass(frozen=True)
class Origin:
    """The stage that made something."""

    command: str
    """what was run, such as "safedagger select datasets/rollout_1 datasets/new_1 --cut 0.5\""""
    parents: tuple[Path, ...]
    """what the pipeline had made before and this stage has read, as `whole` paths"""

    @property
    def stage(self) -> str:
        """The stage's name: the word after `safedagger`."""
        return [*shlex.split(self.command), "", ""][1]

    def option(self, name: str) -> str | None:
        """The value of an option such as "--cut"; None where it was not given."""
        words = shlex.split(self.command)
        return words[words.index(name) + 1] if name in words[:-1] else None

    def shown(self) -> str:
        """The command in markdown, in lines that a shell takes as one."""
        first, *others = re.split(r" (?=--)", self.command)  # an option stays with its value
        lines = [first]
        for part in others:
            if len(lines[-1]) + len(part) > _WIDTH:
                lines.append("   ")
            lines[-1] += f" {part}"
        typed = " \\\n".join(lines)
        return f"The command, with all its parameters:\n\n```sh\n{typed}\n```"


def read_origins(lock: Path) -> dict[Path, Origin]:
    """The origin of all that the pipeline has made, by its `whole` path.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is no dvc.lock.
    """
    if not lock.is_file():
        raise FileNotFoundError(f"{lock}: no such file, expected a dvc.lock")
    try:
        stages = yaml.safe_load(lock.read_text(encoding="utf-8"))["stages"].values()
        made = [(stage, whole(lock.parent / out)) for stage in stages for out in _of(stage, "outs")]
        outs = {path for _, path in made}
        return {path: _origin(stage, lock.parent, outs) for stage, path in made}
    except (yaml.YAMLError, UnicodeDecodeError, AttributeError, KeyError, TypeError):
        raise ValueError(f"{lock}: expected a dvc.lock, with stages, their cmd and outs") from None


def whole(path: Path) -> Path:
    """The path from the root of the file system: to compare by, never to be shown."""
    return Path(os.path.abspath(path))


def _origin(stage: Mapping[str, Any], root: Path, outs: set[Path]) -> Origin:
    read = [whole(root / dep) for dep in _of(stage, "deps")]
    return Origin(" ".join(stage["cmd"].split()), tuple(path for path in read if path in outs))


def _of(stage: Mapping[str, Any], part: str) -> list[str]:
    return [entry["path"] for entry in stage.get(part, [])]
