"""What all iterations of a run have come to, read from their metrics."""

import json
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from itertools import product
from pathlib import Path
from typing import Any

from pipeline.data.ledger import Ledger
from pipeline.evaluation.outcomes import Outcome, read_outcomes
from pipeline.evaluation.summary import CONDITIONS, Performance, condition
from pipeline.policies.strategies import Strategy

STRATEGIES = (Strategy.NAIVE, Strategy.SAFE)


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


@dataclass(frozen=True)
class Iteration:
    """One iteration: its policies' driving, what it cost, and how good its safety policy is."""

    number: int
    driving: Mapping[Strategy, Mapping[str, Performance]]
    """[strategy][condition]"""
    drives: list[Outcome]
    ledger: Ledger
    tau: float
    held_out: SafetyQuality
    """on held-out frames of D_safe, which the reference drove"""
    next_rollout: SafetyQuality | None
    """on what its policies met in collecting for the next iteration; None for the last"""

    @property
    def tracks(self) -> list[str]:
        """Names of the test tracks, sorted."""
        return sorted({drive.track for drive in self.drives})

    def drives_of(self, strategy: Strategy, where: str, track: str) -> list[Outcome]:
        """The drives of one strategy and condition on one track."""
        case = (strategy, where, track)
        return [d for d in self.drives if (d.strategy, condition(d), d.track) == case]


@dataclass(frozen=True)
class Results:
    """A whole run."""

    iterations: list[Iteration]
    """0 (supervised) to M, M >= 1"""
    d_safe: Ledger

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
        d_safe=MetricsFile(metrics / "ledger_D_safe.json").record(Ledger),
    )


def _iteration(metrics: Path, number: int, last: int) -> Iteration:
    step = _step(number)
    driving = MetricsFile(metrics / f"driving_{step}.json")
    safety = MetricsFile(metrics / f"safety_{step}.json")
    return Iteration(
        number=number,
        driving={
            strategy: {
                condition: driving.record(Performance, strategy, condition)
                for condition in CONDITIONS
            }
            for strategy in STRATEGIES
        },
        drives=_drives(metrics / f"drives_{step}.csv"),
        ledger=MetricsFile(metrics / f"ledger_D_{step}.json").record(Ledger),
        tau=safety.number("tau"),
        held_out=safety.record(SafetyQuality, "held_out"),
        next_rollout=None
        if number == last
        else MetricsFile(metrics / f"rollout_{_step(number + 1)}.json").record(
            SafetyQuality, "rollout"
        ),
    )


def _step(iteration: int) -> str:
    """As dvc.yaml calls it."""
    return f"safedagger_{iteration}" if iteration else "0"


def _drives(path: Path) -> list[Outcome]:
    """Every strategy, in every condition, on every track."""
    drives = read_outcomes(path)
    found = {(drive.strategy, condition(drive), drive.track) for drive in drives}
    tracks = {drive.track for drive in drives}
    for case in product(STRATEGIES, CONDITIONS, sorted(tracks)):
        if case not in found:
            raise ValueError(f"{path}: no drive of {', '.join(case)}, expected at least one")
    return drives


class MetricsFile:
    """A JSON file of metrics, of which we take what we know and leave the rest alone."""

    def __init__(self, path: Path) -> None:
        self._path = path
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such file, expected the metrics of an iteration")
        try:
            self._content = json.loads(path.read_text(), parse_constant=_refuse)
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


def _refuse(constant: str) -> None:
    """Python would read NaN and Infinity."""
    raise ValueError(f"found {constant}")
