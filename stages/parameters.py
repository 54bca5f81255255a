"""What an experiment is told, read and checked before anything of it runs."""

import re
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from pipeline.runs import Comparison

PROTOCOL = "item.protocol"
"""What a command says that collects by the protocol of a run."""


def read(params: Path, pipeline: Path) -> "Comparison":
    """What params.yaml compares, once all of its names are known to the pipeline, a dvc.yaml.

    FileNotFoundError where one of the two is missing. ValueError where a run is not one, or is to
    be evaluated by a strategy that there is not; a key of a group is no option of the command that
    dvc.yaml expands the group in; any other name is one that dvc.yaml never uses.
    """
    from pipeline.loops import loops
    from pipeline.rollout.strategies import DRIVING
    from pipeline.runs import Comparison, read_params

    given, house = read_params(params), read_params(pipeline)
    comparison = Comparison.of(given)
    for name, run in comparison.runs.items():
        for strategy in run.strategies:
            if strategy not in DRIVING:
                raise ValueError(
                    f"{params}: runs.{name}.driven_by: {strategy!r}, "
                    f"expected one of {', '.join(DRIVING)}"
                )
    used = set(re.findall(r"\$\{([\w-]+)", str(house)))
    known = (used - {"item", "key"} - loops(comparison).keys()) | Comparison.model_fields.keys()
    for name in given:
        if name not in known:
            raise ValueError(
                f"{params}: {name}: {pipeline} has no ${{{name}}}, {_near(name, known)}"
            )
    for command, groups, options in _expanded(house, given, comparison.protocols):
        for group, keys in groups.items():
            for key in keys:
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
    house: Mapping[str, Any], given: Mapping[str, Any], protocols: Mapping[str, dict[str, Any]]
) -> Iterator[tuple[str, dict[str, dict[str, Any]], set[str]]]:
    """Each command with groups of parameters in it, these, and the names of its options."""
    from stages.__main__ import commands

    for stage in house.get("stages", {}).values():
        told = stage.get("do", stage).get("cmd", "")
        program, command, *words = [*str(told).split(), "", ""]
        names = list(map(_name, words))
        groups = {name: given[name] for name in names if isinstance(given.get(name), dict)}
        if PROTOCOL in names:
            groups |= {f"protocols: {name}": protocol for name, protocol in protocols.items()}
        if program != "safedagger" or not groups:
            continue
        typed = [command, *words]
        typed += [f"--{key}={value}" for group in groups.values() for key, value in group.items()]
        app = typer.main.get_command(commands(typed))
        parameters = app.commands[command].params  # type: ignore[attr-defined]
        yield command, groups, {option.lstrip("-") for each in parameters for option in each.opts}


def _name(word: str) -> str:
    """Of ${name}, else nothing."""
    found = re.fullmatch(r"\$\{([\w.-]+)\}", word)
    return found[1] if found else ""
