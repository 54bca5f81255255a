"""Reading a JSON file of metrics: what is missing or wrong is named in one line."""

import json
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class SafetyQuality:
    """How well a safety policy finds unsafe frames. None where that is not defined."""

    auroc: float | None
    recall: float | None
    """share of the truly unsafe that it calls unsafe"""
    precision: float | None
    """share of what it calls unsafe that truly is"""
    share_unsafe: float | None
    """truly, by tau"""
    share_predicted_unsafe: float | None


class MetricsFile:
    """A JSON file of metrics, of which we take what we know and leave the rest alone."""

    def __init__(self, path: Path) -> None:
        self._path = path
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such file, expected the metrics of an iteration")
        try:
            self.content = json.loads(path.read_text(), parse_constant=_refuse)
        except ValueError as error:
            raise ValueError(f"{path}: {error}, expected JSON") from None

    def record[Record](self, kind: type[Record], *keys: str) -> Record:
        """The dataclass `kind`, all of numbers, from the object at `keys`."""
        known: tuple[Any, ...] = fields(kind)  # type: ignore[arg-type]
        return kind(
            **{
                field.name: self.number(*keys, field.name, nullable="None" in str(field.type))
                for field in known
            }
        )

    def has(self, *keys: str) -> bool:
        """Whether there is anything at `keys`."""
        return self._at(keys) is not MISSING

    def number(self, *keys: str, nullable: bool = False) -> Any:
        """The number at `keys`; None for null where that is allowed."""
        value = self._at(keys)
        if isinstance(value, int | float) and not isinstance(value, bool):
            return value
        if value is None and nullable:
            return None
        found = "nothing" if value is MISSING else json.dumps(value)
        raise ValueError(f"{self._path}: {'.'.join(keys)} is {found}, expected a number")

    def numbers(self, *keys: str) -> dict[str, float | None]:
        """All numbers in the object at `keys`, by name; None for null."""
        value = self._at(keys)
        if not isinstance(value, dict):
            raise ValueError(f"{self._path}: {'.'.join(keys)} is no object, expected numbers")
        return {name: self.number(*keys, name, nullable=True) for name in value}

    def text(self, *keys: str) -> str:
        """The text at `keys`."""
        value = self._at(keys)
        if isinstance(value, str):
            return value
        found = "nothing" if value is MISSING else json.dumps(value)
        raise ValueError(f"{self._path}: {'.'.join(keys)} is {found}, expected text")

    def _at(self, keys: tuple[str, ...]) -> Any:
        """What is there; MISSING where nothing is."""
        value = self.content
        for key in keys:
            value = value.get(key, MISSING) if isinstance(value, dict) else MISSING
        return value


def _refuse(constant: str) -> None:
    """Python would read NaN and Infinity."""
    raise ValueError(f"found {constant}")
