"""The `safedagger` command: every stage of Algorithm 1 under one roof."""

import sys

import typer
from typer import TyperException

from stages import (
    cards,
    collect,
    compare,
    compare_policies,
    contact_sheet,
    errors,
    evaluate,
    film,
    inspect,
    ledger,
    merge,
    report,
    rollout,
    rollout_dagger,
    sample,
    select,
    train_primary,
    train_safety,
    watch,
)

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="SafeDAgger (Zhang & Cho 2016) on LeRobot datasets. Each command is one step of Algorithm 1.",
)
for stage in (
    collect,
    train_primary,
    train_safety,
    rollout,
    select,
    rollout_dagger,
    sample,
    merge,
    ledger,
    evaluate,
    errors,
    contact_sheet,
    film,
    cards,
    report,
    inspect,
    compare,
    compare_policies,
    watch,
):
    app.add_typer(stage.app)


def main() -> None:
    """Run a stage. Bad input is one line on stderr and exit code 2."""
    try:
        code = app(prog_name="safedagger", standalone_mode=False)
    except TyperException as error:
        _refuse(error.format_message())
    except (ValueError, FileNotFoundError, FileExistsError, NotADirectoryError) as error:
        _refuse(str(error))
    sys.exit(code or 0)


def _refuse(problem: str) -> None:
    print(f"safedagger: {' '.join(problem.split())}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
