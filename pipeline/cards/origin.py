"""Where a dataset or a policy comes from, in words, from what safedagger.json says."""

import shlex
from collections.abc import Mapping
from typing import Any

from pipeline.data.lineage import Made

_WIDTH = 96
_COMMANDS = {
    **dict.fromkeys(("D_0", "D_safe", "D_held", "supervised"), "collect"),
    "primary": "train-primary",
    "safety": "train-safety",
}
"""By purpose, where the command has another name."""


def shown(made: Made) -> str:
    """The command in markdown, without its paths, in lines that a shell takes as one."""
    lines = [f"safedagger {_COMMANDS.get(made.purpose, made.purpose)}"]
    for part in _options(made.arguments):
        if len(lines[-1]) + len(part) > _WIDTH:
            lines.append("   ")
        lines[-1] += f" {part}"
    typed = " \\\n".join(lines)
    return f"The command, with all its parameters, less paths, workers and device:\n\n```sh\n{typed}\n```"


def _options(arguments: Mapping[str, Any]) -> list[str]:
    """An option stays with its value."""
    options = []
    for name, value in arguments.items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, bool):
            options.append(option if value else f"--no-{option[2:]}")
        elif not isinstance(value, dict):
            options.append(f"{option} {shlex.quote(str(value))}")
    return options
