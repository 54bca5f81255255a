"""What all iterations of a run have come to, read from their metrics."""

import json
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

from pipeline.data.ledger import Ledger
from pipeline.evaluation.outcomes import Outcome, read_outcomes
from pipeline.evaluation.summary import CONDITIONS, Performance
from pipeline.policies.strategies import Strategy

STRATEGIES = (Strategy.NAIVE, Strategy.SAFE)


@dataclass(frozen=True)
class SafetyQuality:
    """How well a safety policy finds the unsafe frames among some. None where there is no answer."""

    auroc: float | None
    recall: float | None
    """share of the truly unsafe that it calls unsafe"""
    precision: float | None
    """share of what it calls unsafe that truly is"""
    share_unsafe: float | None
    share_predicted_unsafe: float | None


@dataclass(frozen=True)
class Rollout:
    """What the policies of an iteration met when they drove to collect data for the next."""

    quality: SafetyQuality
    measuring_queries: int
    """frames in which the reference was asked only to measure"""


@dataclass(frozen=True)
class Iteration:
    """One iteration: its policies' driving, what it cost, and how good its safety policy is."""

    number: int
    driving: Mapping[str, Mapping[str, Performance]]
    """[strategy][condition]"""
    drives: list[Outcome]
    ledger: Ledger
    threshold: float
    """tau"""
    share_safe: float
    """of D_safe, by tau"""
    held_out: SafetyQuality
    """on held-out frames that the reference drove"""
    next_rollout: Rollout | None
    """None for the last iteration: nothing was collected with its policies"""


@dataclass(frozen=True)
class Results:
    """A whole run."""

    iterations: list[Iteration]
    """0 (supervised) to M, M >= 1"""
    d_safe_queries: int
    """frames of D_safe, all driven by the reference"""

    @property
    def first(self) -> Iteration:
        """The supervised stage."""
        return self.iterations[0]

    @property
    def last(self) -> Iteration:
        return self.iterations[-1]

    @property
    def loop(self) -> list[Iteration]:
        """Iterations 1 to M: where the paper counts queries."""
        return self.iterations[1:]


def read_results(metrics: Path, iterations: int) -> Results:
    """Read driving, drives, ledger and safety of iterations 0 to `iterations`, and their rollouts.

    Raises:
        FileNotFoundError: a file is missing.
        ValueError: a file does not hold what it should; `iterations` is below 1.
    """
    if iterations < 1:
        raise ValueError(f"iterations {iterations}: expected at least 1")
    return Results(
        [_iteration(metrics, number, iterations) for number in range(iterations + 1)],
        d_safe_queries=_File(metrics / "ledger_0.json").number("d_safe_queries"),
    )


def _iteration(metrics: Path, number: int, last: int) -> Iteration:
    driving = _File(metrics / f"driving_{number}.json")
    safety = _File(metrics / f"safety_{number}.json")
    return Iteration(
        number=number,
        driving={
            strategy: {
                condition: driving.record(Performance, strategy, condition)
                for condition in CONDITIONS
            }
            for strategy in STRATEGIES
        },
        drives=read_outcomes(metrics / f"drives_{number}.csv"),
        ledger=_File(metrics / f"ledger_{number}.json").record(Ledger),
        threshold=safety.number("threshold"),
        share_safe=safety.number("share_safe"),
        held_out=safety.record(SafetyQuality, "held_out"),
        next_rollout=_rollout(metrics / f"rollout_{number + 1}.json") if number < last else None,
    )


def _rollout(path: Path) -> Rollout:
    file = _File(path)
    return Rollout(file.record(SafetyQuality, "rollout"), file.number("measuring_queries"))


class _File:
    """A JSON file of metrics, of which we take what we know and leave the rest alone."""

    def __init__(self, path: Path) -> None:
        self._path = path
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such file, expected the metrics of an iteration")
        try:
            self._content = json.loads(path.read_text())
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

    def number(self, *keys: str, nullable: bool = False) -> Any:
        """The number at `keys`; None for null where that is allowed."""
        value = self._content
        for key in keys:
            value = value.get(key, MISSING) if isinstance(value, dict) else MISSING
        if isinstance(value, int | float) and not isinstance(value, bool):
            return value
        if value is None and nullable:
            return None
        found = "nothing" if value is MISSING else json.dumps(value)
        raise ValueError(f"{self._path}: {'.'.join(keys)} is {found}, expected a number")
