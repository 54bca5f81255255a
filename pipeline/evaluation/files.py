"""Reading JSON: what is missing or wrong is named in one line."""

import json
from pathlib import Path

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, create_model

from pipeline.metric import QUALITY


class Ledger(BaseModel):
    """What `data.ledger` counts, with the failures of each kind by their names; None where older
    ledgers lack it.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, int | None]

    frames_driven: int
    queries: int
    frames_selected: int
    frames_trained: int
    takeover: float
    calls: int | None = None
    frames_of_calls: int | None = None
    switches: int | None = None
    drives: int | None = None
    scenarios: int | None = None
    audits: int | None = None
    put_back: int | None = None
    failures: int | None = None


Quality = create_model(
    "Quality",
    tau=(float, ...),
    frames=(float, ...),
    calibration=(list[list[float]], []),
    **{each.part: (float | None, None) for each in QUALITY.values()},  # type: ignore[call-overload]
)
"""What `learning.quality` finds in so many frames, by labels of a tau; None where it is not defined,
or was not measured yet."""


class ErrorShares(BaseModel):
    """Which of the supervised primary's errors are safe, on frames that the reference drove."""

    class Safe(BaseModel):
        """Of some frames."""

        share_safe: float
        tau_for_share: float | None = None
        """which would call `share` of them safe; None where nobody asked"""

    tau: float
    share: float | None = None
    trained_on: Safe
    held_out: Safe


class Setting(BaseModel):
    """What a condition of a task sets."""

    condition: str
    name: str
    laps: float | None = None
    """[laps] after which a drive of the car is over"""


class Rows[Row: BaseModel](BaseModel):
    """What a command has measured: beside few numbers for DVC, which leaves lists alone, all of it."""

    rows: list[Row]


def read_json[Kind](path: Path, kind: type[Kind]) -> Kind:
    """What is in a file, as `kind` has it; what that does not know is left alone. FileNotFoundError where
    there is none, ValueError where it is not such a file.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file, expected JSON")
    try:
        content = json.loads(path.read_text(), parse_constant=_refuse)
        return TypeAdapter(kind).validate_python(content, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the whole"
        raise ValueError(f"{path}: {place}: {first['msg']}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}, expected JSON") from None


def _refuse(constant: str) -> None:
    """Python would read NaN and Infinity."""
    raise ValueError(f"found {constant}")
