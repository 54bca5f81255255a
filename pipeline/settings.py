"""What a command can be told, as the fields of a frozen dataclass: each says what it is, once."""

import math
from dataclasses import KW_ONLY, dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints


@dataclass(frozen=True)
class Setting:
    """What there is to know of a field: `Annotated[int, Setting("Other cars.", 0)] = 20`."""

    help: str
    """one sentence, with the unit"""
    at_least: float = -math.inf
    _: KW_ONLY
    above: float = -math.inf
    at_most: float = math.inf
    below: float = math.inf
    finite: bool = True
    """whether infinity, no limit at all, is refused"""

    def check(self, name: str, value: float) -> None:
        """Raise a one-line ValueError that names `name` unless `value` is in the range."""
        good = self.at_least <= value <= self.at_most and (math.isfinite(value) or not self.finite)
        # "below" is infinity where nothing is said, and infinity is not below it
        if good and value > self.above and (value < self.below or self.below == math.inf):
            return
        bounds = {"at least": self.at_least, "above": self.above}
        bounds |= {"at most": self.at_most, "below": self.below}
        told = " and ".join(f"{word} {b:g}" for word, b in bounds.items() if math.isfinite(b))
        raise ValueError(f"{name} is {value}, expected a number {told}".rstrip())


class Settings:
    """A frozen dataclass: its fields with a `Setting` are what commands take.

    A subclass with a `__post_init__` of its own calls this one first. ValueError where a number is out of
    its range, or a word is none of those that there are.
    """

    def __post_init__(self) -> None:
        for name, (kind, setting, _) in settings(type(self)).items():
            value, words = getattr(self, name), get_args(kind)
            if get_origin(kind) is Literal and value not in words:
                expected = " or ".join(map(repr, words))
                raise ValueError(f"{name} is {value!r}, expected {expected}")
            if kind in (int, float):
                setting.check(name, value)


def settings(kind: type) -> dict[str, tuple[Any, Setting, Any]]:
    """By the name of a field with a `Setting`: its type, that, and its default or `MISSING`."""
    hints = get_type_hints(kind, include_extras=True)
    told = {each.name: (hints[each.name], each.default) for each in fields(kind)}
    return {
        name: (hint.__origin__, hint.__metadata__[0], default)
        for name, (hint, default) in told.items()
        if hasattr(hint, "__metadata__")
    }


def listed(told: str) -> list[str]:
    """What is separated by commas, each once."""
    return list(dict.fromkeys(name.strip() for name in told.split(",")))
