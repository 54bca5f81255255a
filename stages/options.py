"""Arguments that several stages share, and how stages show what they do."""

import inspect
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import MISSING
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.models import ArgumentInfo

from pipeline.output import check_place
from pipeline.registry import LESSONS, TASKS
from pipeline.settings import Setting, Settings, settings

if TYPE_CHECKING:
    from rerun.blueprint import Blueprint

    from pipeline.inspection.rerun_sinks import Sink
    from pipeline.learning.fitting import OnEpoch
    from pipeline.policies.lesson import Lesson
    from pipeline.task import Task
else:
    Task, Lesson = "Task", "Lesson"  # what can be any: see `chosen`

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
Resume = Annotated[
    float | None,
    typer.Option(
        min=0,
        max=1,
        help="By the safe strategy the reference, once it drives, hands back at this safe "
        "probability; by default at the cut.",
    ),
]
Least = Annotated[
    float | None,
    typer.Option(min=0, help="... and drives for so long [s] at least, to the nearest frame; 0."),
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
MetricsIfAny = Annotated[
    Path | None,
    typer.Option(help="Where to write what was measured, too (JSON). It must not exist."),
]
Curve = Annotated[
    Path | None,
    typer.Option(help="Where to write the losses after each epoch, too (CSV). It must not exist."),
]
Params = Annotated[
    Path, typer.Option(help="What an experiment is told: runs, and the numbers of its stages.")
]
Loops = Annotated[Path, typer.Option(help="The loops of dvc.yaml, as `plan` unrolls the runs.")]
Pipeline = Annotated[
    Path, typer.Option(help="What takes the parameters: only names in it are known.")
]
Iteration = Annotated[int, typer.Option(min=1, help="The iteration that this is for.")]
Seed = Annotated[
    int, typer.Option(min=0, help="Of every random choice: equal seeds give equal bytes.")
]
Device = Annotated[
    str,
    typer.Option(
        help="Where networks compute: cpu, cuda, cuda:1, mps. Another may give other last bits."
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        min=1, help="Processes, by default one for each core. The result does not depend on it."
    ),
]

Save = Annotated[
    Path | None, typer.Option(help="Write a Rerun file (.rrd) instead. It must not exist.")
]
Web = Annotated[bool, typer.Option("--web", help="Serve it to a browser on this machine instead.")]
Port = Annotated[
    int,
    typer.Option(min=0, help="Where --web serves its page; its data is at the next. 0: any two."),
]


def chosen(command: Callable[..., None], typed: Sequence[str]) -> Callable[..., None]:
    """The command with options in the place of each parameter that is a dataclass of `Settings`.

    One that is a Task or a Lesson can be any: which one, an option of the parameter's name says,
    `--task driving`. So what a command takes is known only when it is called: see `typed`. ValueError
    where there is no such task or policy.
    """
    signature = inspect.signature(command)
    parameters, made = [], {}
    for given in signature.parameters.values():
        name, kind = given.name, given.annotation
        if kind in ("Task", "Lesson"):
            known, kind = _named(kind, _after(f"--{name}", typed, "driving"))
            listed = f"{', '.join(known)}, or module:class; with --help after it, its options."
            which = typer.Option(help=listed)
            parameters.append(_parameter(name, Annotated[str, which], kind.name))
        if isinstance(kind, type) and issubclass(kind, Settings):
            made[name] = kind, (own := settings(kind))
            parameters += [_option(field, *told) for field, told in own.items()]
        else:
            parameters.append(_parameter(name, kind, given.default))

    def called(**given: Any) -> None:
        for name, (kind, own) in made.items():
            given[name] = kind(**{field: given.pop(field) for field in own})
        command(**given)

    called.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    called.__name__, called.__doc__ = command.__name__, command.__doc__
    return called


def _named(seam: str, name: str) -> tuple[Iterable[str], Any]:
    """What there is by name beyond a seam, and what has this one."""
    if seam == "Task":
        from pipeline.task import load_task

        return TASKS, load_task(name)
    from pipeline.policies.lesson import load_lesson

    return LESSONS, load_lesson(name)


def _after(option: str, typed: Sequence[str], default: str) -> str:
    """The value of an option on a command line."""
    for word, following in pairwise([*typed, ""]):
        if word == option:
            return following
        if word.startswith(f"{option}="):
            return word.partition("=")[2]
    return default


def _option(name: str, kind: Any, setting: Setting, default: Any) -> inspect.Parameter:
    """A field as an option; an open end of its range is for the dataclass to refuse."""
    least, most = max(setting.at_least, setting.above), min(setting.at_most, setting.below)
    ends = [end if math.isfinite(end) else None for end in (least, most)]
    option = typer.Option(help=setting.help, min=ends[0], max=ends[1])
    default = inspect.Parameter.empty if default is MISSING else default
    return _parameter(name, Annotated[kind, option], default)


def _parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """A parameter of a command. Paths without dashes are looked at before anything is imported."""
    for told in getattr(annotation, "__metadata__", ()):
        if isinstance(told, ArgumentInfo):
            if name in ("output", "aside"):
                told.callback = _free
            else:
                told.exists = True
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, kind, annotation=annotation, default=default)


def _free(output: Path) -> Path:
    check_place(output)
    return output


def arguments(context: typer.Context) -> dict[str, Any]:
    """What a command was given that decides what it makes: no paths, workers or device."""
    return {
        # JSON knows no infinity: no limit at all
        name: str(value) if value == math.inf else value
        for name, value in context.params.items()
        if value is not None
        and not isinstance(value, Path | list | tuple)
        and name not in ("workers", "device")
    }


def endings(why: Iterable[str]) -> str:
    """Why drives ended, and how many for each reason."""
    return "ended: " + ", ".join(f"{reason} {n}" for reason, n in Counter(why).most_common())


@contextmanager
def progress(what: str, total: float) -> Iterator[Callable[[float], None]]:
    """A bar with the time left, on a terminal; the block tells what it is given how far it is."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bars:
        bar = bars.add_task(what, total=total)
        yield lambda done: bars.update(bar, completed=done)


@contextmanager
def epochs(samples: int, curve: Path | None) -> Iterator["OnEpoch"]:
    """What to tell after each epoch of a training: a bar shows how far it is, `curve` how good. Where the
    block fails, no curve is left.
    """
    from pipeline.evaluation.writing import write_curve

    told: list[Mapping[str, float]] = []
    with progress("training", samples) as advance_to:

        def on_epoch(epoch: int, epochs: int, metrics: Mapping[str, float]) -> None:
            told.append(metrics)
            advance_to(metrics["samples"])
            if curve:
                write_curve(curve, told)

        try:
            yield on_epoch
        except BaseException:
            if curve:
                curve.unlink(missing_ok=True)
            raise


def figures(metrics: Mapping[str, Any]) -> str:
    """Metrics on one line: of what is measured, the numbers."""
    numbers = {name: value for name, value in metrics.items() if isinstance(value, Real)}
    return ", ".join(f"{name} {value:.4g}" for name, value in numbers.items())


@contextmanager
def rerun_sink(save: Path | None, web: bool, port: int, blueprint: "Blueprint") -> Iterator["Sink"]:
    """The file `save`, or a page for a browser, or else a window: until it is closed, or Ctrl-C."""
    from pipeline.inspection.rerun_sinks import into_file, into_viewer

    if save is not None and web:
        raise typer.BadParameter("--save and --web exclude each other")
    if port and not web:
        raise typer.BadParameter("--port is where --web serves its page")
    if save is not None:
        with into_file(save, blueprint) as sink:
            yield sink
        typer.echo(f"{save}: open it with `rerun {save}`")
        return
    with suppress(KeyboardInterrupt), into_viewer(blueprint, web=web, port=port) as sink:
        if sink.page is not None:
            both = " ".join(f"-L {port}:127.0.0.1:{port}" for port in sink.ports)
            typer.echo(f"{sink.page} (Ctrl-C to end; elsewhere after `ssh {both} <this machine>`)")
        yield sink
