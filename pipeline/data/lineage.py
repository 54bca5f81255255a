"""What a dataset or a policy is and comes from: safedagger.json beside what it tells about.

LeRobot drops what it does not know from meta/info.json, and DVC knows only the files that it ran.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

FILE = "safedagger.json"


@dataclass(frozen=True)
class Made:
    """How something was made."""

    purpose: str
    """what it is for: "D_0", "rollout", "select", "merge", ...; "foreign" where we did not make it"""
    arguments: Mapping[str, Any]
    """of the command, by name: those that decide the content, so no paths, workers or device"""
    parents: tuple[str, ...]
    """sha256 of what it was made from, in the order of the command"""


@dataclass(frozen=True)
class Lineage:
    """One thing with all that it was made from."""

    sha256: str
    """of its content and of how it was made, in hexadecimal: of a policy, of its weights"""
    made: Mapping[str, Made]
    """by sha256: of itself, and of all its ancestors"""

    @property
    def id(self) -> int:
        """The first 63 bits of its sha256: `source.dataset` of what was recorded in it."""
        return first_bits(self.sha256)

    @property
    def own(self) -> Made:
        """How it was made itself."""
        return self.made[self.sha256]

    @property
    def parents(self) -> list[Self]:
        """What it was made from."""
        return [type(self)(parent, self.made) for parent in self.own.parents]

    @classmethod
    def foreign(cls, sha256: str) -> Self:
        """Of what somebody else has made."""
        return cls(sha256, {sha256: Made("foreign", {}, ())})

    @classmethod
    def read(cls, folder: Path) -> Self | None:
        """Of what is in `folder`; None where nothing tells, ValueError where the file that should is not
        one of ours.
        """
        file = folder / FILE
        if not file.is_file():
            return None
        try:
            content = json.loads(file.read_text(encoding="utf-8"))
            made = {
                sha256: Made(each["purpose"], each["arguments"], tuple(each["parents"]))
                for sha256, each in content["made"].items()
            }
            lineage = cls(content["sha256"], made)
            for parent in {lineage.sha256, *(p for each in made.values() for p in each.parents)}:
                made[parent]
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{file}: {error!r}, expected what safedagger writes there") from None
        return lineage

    def write(self, folder: Path) -> None:
        """Write it into `folder`; equal ones as equal bytes."""
        content = {"sha256": self.sha256, "made": {k: asdict(v) for k, v in self.made.items()}}
        text = json.dumps(content, indent=1, sort_keys=True, allow_nan=False)
        (folder / FILE).write_text(text + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Recipe:
    """How something is being made, whose content nobody knows yet."""

    purpose: str
    arguments: Mapping[str, Any]
    parents: Sequence[Lineage] = ()

    def lineage(self, sha256: str) -> Lineage:
        """Of what it has come to."""
        ancestors = {key: made for parent in self.parents for key, made in parent.made.items()}
        parents = tuple(parent.sha256 for parent in self.parents)
        return Lineage(sha256, {**ancestors, sha256: Made(self.purpose, self.arguments, parents)})


def first_bits(sha256: str) -> int:
    """The first 63 bits, as a number that fits into a column of int64."""
    return int(sha256[:16], 16) >> 1
