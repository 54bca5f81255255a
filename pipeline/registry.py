"""What there is on the far side of each seam, by name: all that knows the tasks and their policies.

One of your own need not stand here: wherever a name is asked for, "module:attribute" will do.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

TASKS = {
    "driving": "pipeline.driving.task:Driving",
    "metaworld": "pipeline.tasks.metaworld:MetaWorld",
}
"""Worlds, see `task.Task`."""

LESSONS = {
    "driving": "pipeline.driving.lesson:DrivingLesson",
    "conv": "pipeline.policies.conv:ConvLesson",
}
"""Kinds of primaries to be trained, see `policies.lesson.Lesson`."""

PRIMARIES = {
    "safedagger_primary": "pipeline.driving.network:PrimaryNetwork",
    "safedagger_conv": "pipeline.policies.conv:ConvActor",
}
"""Networks of saved primaries, by the type in config.json, see `policies.network.ConvNetwork`."""

MEASURES = {
    "mean-square": "pipeline.policies.measures:mean_square",
    "steering": "pipeline.driving.deviation:steering",
    "steering-and-brake": "pipeline.driving.deviation:steering_and_brake",
}
"""How far two actions are apart, see `policies.measures.Measure`."""


def find(what: str, name: str, known: Mapping[str, str]) -> Any:
    """What is `known` by a name, or named as "module:attribute"; ValueError where there is none,
    in which `what` names what was looked for.
    """
    module, _, attribute = known.get(name, name).partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{what} {name!r}: expected one of {', '.join(known)}, or module:name ({error})"
        ) from None


def find_subclass(what: str, name: str, known: Mapping[str, str], kind: type) -> Any:
    """The subclass of `kind` of this name; raises as `find`, too, where it is something else."""
    found = find(what, name, known)
    if not (isinstance(found, type) and issubclass(found, kind)):
        expected = f"{kind.__module__}.{kind.__name__}"
        raise ValueError(f"{what} {name!r} is {found!r}, expected a subclass of {expected}")
    return found
