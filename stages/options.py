"""Arguments that several stages share, and how stages show what they do."""

import inspect
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import MISSING
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.registry import MEASURES

if TYPE_CHECKING:
    from rerun.blueprint import Blueprint

    from pipeline.inspection.rerun_sinks import Sink


class OptimizerName(StrEnum):
    """How to descend."""

    sgd = "sgd"
    adamw = "adamw"


Dataset = Annotated[Path, typer.Argument(help="A LeRobot dataset of this project.")]
Output = Annotated[Path, typer.Argument(help="Where to write. It must not exist.")]
Primary = Annotated[Path, typer.Argument(help="A primary policy, as train-primary writes it.")]
Safety = Annotated[Path, typer.Argument(help="Its safety policy, as train-safety writes it.")]
SafetyIfAny = Annotated[
    Path | None,
    typer.Argument(help="Its safety policy, as train-safety writes it; naive needs none."),
]

Strategy = Annotated[str, typer.Option(help="Driving strategy: naive, safe or optimal.")]
ActionRepeat = Annotated[
    int, typer.Option(min=1, help="Control steps (1/30 s) in a frame: an action is held for them.")
]
Cut = Annotated[
    float | None,
    typer.Option(
        min=0,
        max=1,
        help="A frame is unsafe below this safe probability; by default the safety policy's own.",
    ),
]
Measure = Annotated[
    str, typer.Option(help=f"What deviates: {', '.join(MEASURES)}, or module:function.")
]
Hold = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Of a primary that plans a chunk of actions: do so many of it before the next; 1.",
    ),
]
Metrics = Annotated[
    Path, typer.Option(help="Where to write what was measured (JSON). It must not exist.")
]
Params = Annotated[
    Path, typer.Option(help="What an experiment is told: runs, and the numbers of its stages.")
]
Loops = Annotated[Path, typer.Option(help="The loops of dvc.yaml, as `plan` unrolls the runs.")]
Seed = Annotated[
    int, typer.Option(min=0, help="Of every random choice: equal seeds give equal bytes.")
]
Device = Annotated[
    str,
    typer.Option(
        help="Where networks compute: cpu, cuda, cuda:1, mps. Another may give other last bits."
    ),
]
Workers = Annotated[int, typer.Option(min=1, help="Processes. The result does not depend on it.")]

Save = Annotated[
    Path | None, typer.Option(help="Write a Rerun file (.rrd) instead. It must not exist.")
]
Web = Annotated[bool, typer.Option("--web", help="Serve it to a browser on this machine instead.")]

Optimizer = Annotated[
    OptimizerName, typer.Option(help="sgd is the paper's, adamw one cycle of AdamW.")
]
LearningRate = Annotated[float, typer.Option(help="Above 0; for adamw the highest of the cycle.")]
WeightDecay = Annotated[float, typer.Option(min=0, help="Weight decay.")]
Batch = Annotated[int, typer.Option(min=1, help="Examples in a step.")]
Samples = Annotated[int, typer.Option(min=1, help="Examples shown in all.")]
Validation = Annotated[
    float,
    typer.Option(help="Share of the episodes held out for the validation error, [0, 1)."),
]
Patience = Annotated[
    int, typer.Option(min=1, help="For sgd: epochs without improvement before it stops.")
]
Threads = Annotated[
    int, typer.Option(min=1, help="Processor threads. Another number may give other last bits.")
]


def seam[Command: Callable[..., None]](name: str) -> Callable[[Command], Command]:
    """Let a command that has a parameter `name` ("task" or "policy") choose what it is by an option
    of that name, `--task driving` say, and take the settings of that as further options.

    What is chosen, the command line says, so what a command takes is known only when it is called:
    see `chosen`.
    """

    def mark(command: Command) -> Command:
        command.seam = name  # type: ignore[attr-defined]
        return command

    return mark


def chosen(command: Callable[..., None], typed: Sequence[str]) -> Callable[..., None]:
    """The command with the options of what is `typed`; unchanged if it has no `seam`.

    Raises:
        ValueError: there is no such task or policy.
    """
    name = getattr(command, "seam", None)
    if name is None:
        return command
    from pipeline.policies.lesson import load_lesson
    from pipeline.registry import LESSONS, TASKS
    from pipeline.task import load_task

    known, load = {"task": (TASKS, load_task), "policy": (LESSONS, load_lesson)}[name]
    return _with_settings(command, name, known, load(_after(f"--{name}", typed, "driving")))


def _after(option: str, typed: Sequence[str], default: str) -> str:
    """The value of an option on a command line."""
    for word, following in pairwise([*typed, ""]):
        if word == option:
            return following
        if word.startswith(f"{option}="):
            return word.partition("=")[2]
    return default


def _with_settings(
    command: Callable[..., None], name: str, known: Iterable[str], kind: Any
) -> Callable[..., None]:
    """The command with `--name` and the settings of `kind` in the place of its parameter `name`."""
    from pipeline.task import settings

    own = settings(kind)

    def called(**given: Any) -> None:
        given[name] = kind(**{field: given.pop(field) for field in own})
        command(**given)

    def parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
        kind = inspect.Parameter.KEYWORD_ONLY
        default = inspect.Parameter.empty if default is MISSING else default
        return inspect.Parameter(name, kind, annotation=annotation, default=default)

    which = Annotated[str, typer.Option(help=f"{', '.join(known)}, or module:class.")]
    options = [parameter(name, which, kind.name)] + [
        parameter(
            field,
            Annotated[of, typer.Option(help=setting.help, min=setting.least)],
            default,
        )
        for field, (of, setting, default) in own.items()
    ]
    signature = inspect.signature(command)
    parameters = [
        each
        for given in signature.parameters.values()
        for each in (
            options if given.name == name else [given.replace(kind=inspect.Parameter.KEYWORD_ONLY)]
        )
    ]
    called.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    called.__name__, called.__doc__ = command.__name__, command.__doc__
    return called


def arguments(context: typer.Context) -> dict[str, Any]:
    """What a command was given that decides what it makes: no paths, workers or device."""
    return {
        # JSON knows no infinity: no limit at all
        name: str(value) if isinstance(value, StrEnum) or value == math.inf else value
        for name, value in context.params.items()
        if value is not None and not isinstance(value, Path) and name not in ("workers", "device")
    }


def names(listed: str) -> list[str]:
    """The names in a comma-separated list."""
    return [name.strip() for name in listed.split(",")]


def seen_from(report: Path, picture: Path) -> str:
    """Where `picture` lies, as a link in `report` says it."""
    return Path(os.path.relpath(picture, report.parent)).as_posix()


@contextmanager
def progress(what: str, total: float) -> Iterator[Callable[[float], None]]:
    """A bar with the time left, on a terminal; the block tells what it is given how far it is."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bars:
        bar = bars.add_task(what, total=total)
        yield lambda done: bars.update(bar, completed=done)


def figures(metrics: Mapping[str, float | None]) -> str:
    """Metrics on one line."""
    return ", ".join(f"{name} {value:.4g}" for name, value in metrics.items() if value is not None)


@contextmanager
def rerun_sink(save: Path | None, web: bool, blueprint: "Blueprint") -> Iterator["Sink"]:
    """The file `save`, or a page for a browser, or else a window: until it is closed, or Ctrl-C."""
    from pipeline.inspection.rerun_sinks import into_file, into_viewer

    if save is not None and web:
        raise typer.BadParameter("--save and --web exclude each other")
    if save is not None:
        with into_file(save, blueprint) as sink:
            yield sink
        typer.echo(f"{save}: open it with `rerun {save}`")
        return
    with suppress(KeyboardInterrupt), into_viewer(blueprint, web=web) as sink:
        if sink.page is not None:
            typer.echo(f"{sink.page} (Ctrl-C to end)")
        yield sink
