"""Ours and its floor, measured in turns: on a shared machine only their ratio says something."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from cProfile import Profile
from dataclasses import dataclass
from pstats import Stats
from statistics import median
from time import perf_counter
from typing import Self


@dataclass(frozen=True)
class Row:
    """One line of the table: a part of the pipeline, and the least that it could take."""

    what: str
    """the part, and what it is measured against"""
    ours: float
    floor: float
    """both in `unit`"""
    unit: str
    ratio: float
    """of ours to the floor"""
    target: str = ""
    """of the ratio, such as "at most 3"; empty where there is none"""

    @classmethod
    def timed(
        cls, what: str, times: tuple[float, float, float], scale: float, unit: str, target: str = ""
    ) -> Self:
        """Of what `paired` gives, its seconds times `scale`."""
        ours, floor, ratio = times
        return cls(what, ours * scale, floor * scale, unit, ratio, target)


def paired(
    ours: Callable[[], object], floor: Callable[[], object], repeats: int = 5
) -> tuple[float, float, float]:
    """Medians of `repeats` runs of each in turns: seconds of ours, of the floor, and their ratio.

    Each runs once before that, uncounted. The ratio is the median of each turn's own: what else
    the machine does then slows both.
    """
    ours(), floor()
    turns = [(seconds(ours), seconds(floor)) for _ in range(repeats)]
    return (
        median(own for own, _ in turns),
        median(least for _, least in turns),
        median(own / least for own, least in turns),
    )


def shares(what: str, run: Callable[[], object], parts: Mapping[str, str]) -> Iterator[Row]:
    """What a run spends its time on, by cProfile, which slows many short calls more than few long ones.

    Args:
        parts: what to say of a function, such as "pipeline/driving/camera.py:render", by that; none
            of them calls another.
    """
    profile = Profile()
    profile.runcall(run)
    spent = Stats(profile)
    took = {f"{file}:{name}": row[3] for (file, _, name), row in spent.stats.items()}  # type: ignore[attr-defined]
    whole = spent.total_tt  # type: ignore[attr-defined]
    for function, told in parts.items():
        (own,) = (time for place, time in took.items() if place.endswith(function))
        yield Row(f"{what}: {told}", own, whole, "s", own / whole)


def seconds(run: Callable[[], object]) -> float:
    """How long a run takes [s]."""
    start = perf_counter()
    run()
    return perf_counter() - start


def table(rows: Iterable[Row]) -> str:
    """The rows in Markdown."""
    lines = [
        "| what | ours | floor | unit | ratio | target |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        figures = (f"{number:.3g}" for number in (row.ours, row.floor))
        lines.append(
            f"| {row.what} | {' | '.join(figures)} | {row.unit} | {row.ratio:.2f} | {row.target} |"
        )
    return "\n".join(lines)
