"""The `safedagger` command: every stage of Algorithm 1 under one roof."""

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import version as version_of
from typing import Annotated

import typer
from typer import TyperException

from stages import options

STAGES = (
    "plan",
    "collect",
    "split",
    "train-primary",
    "train-safety",
    "rollout",
    "select",
    "rollout-dagger",
    "sample",
    "merge",
    "ledger",
    "evaluate",
    "errors",
    "judge",
    "contact-sheet",
    "film",
    "runs",
    "cards",
    "report",
    "results",
    "inspect",
    "compare",
    "compare-policies",
    "watch",
)
"""All commands: of each, a file has a function of its name."""

ENVIRONMENT = {
    # Commands work on this disk alone: else LeRobot answers a mistyped path by asking the network.
    "HF_HUB_OFFLINE": "1",
    # PyTorch's threads sleep where they wait for one another: where something else runs on the
    # machine, those that spin take the processor from those they wait for.
    "OMP_WAIT_POLICY": "PASSIVE",
    # MuJoCo draws without a display; elsewhere than on Linux it always does, and knows no EGL.
    **({"MUJOCO_GL": "egl"} if sys.platform == "linux" else {}),
}
"""What the commands set for themselves, unless the user has. Libraries read it when first imported."""


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"safedagger {version_of('safedagger')}")
        raise typer.Exit


def commands(typed: Sequence[str]) -> typer.Typer:
    """All commands; those with a seam take the settings of the task or policy that is `typed`. Where one
    is typed, of the others there is nothing but the name: what they take need not be imported.
    Raises as `options.chosen`.
    """
    app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode=None)
    app.callback()(safedagger)
    one = typed[0] if typed and typed[0] in STAGES else None
    for name in STAGES:
        known = one in (None, name)
        app.command(name)(options.chosen(_command(name), typed) if known else lambda: None)
    return app


def _command(name: str) -> Callable[..., None]:
    name = name.replace("-", "_")
    return getattr(import_module(f"stages.{name}"), name)


def safedagger(
    version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_version, help="Say which, and exit."),
    ] = False,
) -> None:
    """SafeDAgger (Zhang & Cho 2016) on LeRobot datasets. Each command is one step of Algorithm 1."""


def main() -> None:
    """Run a stage. Bad input is one line on stderr and exit code 2, a fault of the machine code 1."""
    sys.path.append(os.getcwd())  # of "module:name" on the command line
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    try:
        code = commands(sys.argv[1:])(prog_name="safedagger", standalone_mode=False)
    except TyperException as error:
        _end(error.format_message(), 2)
    except (ValueError, FileNotFoundError, FileExistsError, NotADirectoryError) as error:
        _end(str(error), 2)
    except (OSError, MemoryError) as error:
        _end(str(error) or "there is not enough memory", 1)
    sys.exit(code or 0)


def _end(problem: str, code: int) -> None:
    print(f"safedagger: {' '.join(problem.split())}", file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
