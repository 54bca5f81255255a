"""What an experiment is told, read and checked before anything of it runs."""

import re
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from pipeline.runs import Comparison


def read(params: Path, pipeline: Path) -> "Comparison":
    """What params.yaml compares, once all of its names are known to the pipeline, a dvc.yaml.

    Raises:
        FileNotFoundError: one of the two is missing.
        ValueError: a run is not one; a key of a group is no option of the command that dvc.yaml
            expands the group in; any other name is one that dvc.yaml never uses.
    """
    from pipeline.loops import loops
    from pipeline.runs import Comparison, read_params

    given, house = read_params(params), read_params(pipeline)
    comparison = Comparison.of(given)
    used = set(re.findall(r"\$\{([\w-]+)", str(house)))
    known = {*used, "runs", "thresholds"} - {"item", "key"} - loops(comparison).keys()
    for name in given:
        if name not in known:
            raise ValueError(
                f"{params}: {name}: {pipeline} has no ${{{name}}}, {_near(name, known)}"
            )
    for command, group, options in _expanded(house, given):
        for key in given[group]:
            if key not in options:
                raise ValueError(
                    f"{params}: {group}: {key} is no option of `safedagger {command}`, "
                    f"{_near(key, options)}"
                )
    return comparison


def _near(name: Any, known: Iterable[str]) -> str:
    (nearest,) = get_close_matches(str(name), sorted(known), 1, cutoff=0)
    return f"expected one such as {nearest}"


def _expanded(
    house: Mapping[str, Any], given: Mapping[str, Any]
) -> Iterator[tuple[str, str, set[str]]]:
    """Each command with a group of parameters in it, the group, and the names of its options."""
    from stages.__main__ import commands

    for stage in house.get("stages", {}).values():
        told = stage.get("do", stage).get("cmd", "")
        program, command, *words = [*str(told).split(), "", ""]
        groups = [name for name in map(_name, words) if isinstance(given.get(name), dict)]
        if program != "safedagger" or not groups:
            continue
        typed = [command, *words]
        typed += [f"--{key}={value}" for name in groups for key, value in given[name].items()]
        app = typer.main.get_command(commands(typed))
        parameters = app.commands[command].params  # type: ignore[attr-defined]
        names = {option.lstrip("-") for each in parameters for option in each.opts}
        yield from ((command, group, names) for group in groups)


def _name(word: str) -> str:
    """Of ${name}, else nothing."""
    found = re.fullmatch(r"\$\{([\w-]+)\}", word)
    return found[1] if found else ""
