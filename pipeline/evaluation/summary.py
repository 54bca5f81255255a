"""From evaluated drives to the metrics of Sec. 4.4."""

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from pipeline.evaluation.outcomes import Outcome

LAPS = 3.0
"""A drive is halted after so many laps (Sec. 4.4)."""
CONDITIONS = ("no_traffic", "traffic")


@dataclass(frozen=True)
class Performance:
    """The metrics of a group of drives. None where there is nothing to divide by."""

    laps: float
    """mean over the tracks of the mean over the starts, each drive at most LAPS"""
    damage_per_lap: float | None
    """[m^2/s^2] all damage over all laps driven, as distance; None where no distance was driven"""
    steering_mse: float | None
    """mean deviation over all frames that the primary drove; None where it drove none"""
    takeover: float
    """share of all frames in which the reference drove, [0, 1]"""
    takeover_length: float | None
    """mean length of a takeover [frames]; None where there was none"""
    switches_per_lap: float | None
    """changes of driver per lap driven; None where no distance was driven"""
    off_road: float
    """share of the drives that left the road, [0, 1]"""
    drives: int
    frames: int
    """frames driven"""
    measuring_queries: int
    """frames in which the reference was asked only to measure: what `steering_mse` rests on"""


def measure(outcomes: Iterable[Outcome]) -> Performance:
    """The metrics of some drives, of one strategy and condition; their order does not matter.

    Raises:
        ValueError: no drives.
    """
    drives = list(outcomes)
    if not drives:
        raise ValueError("there are no drives, expected at least one")
    frames = sum(drive.frames for drive in drives)
    measured = sum(drive.primary_frames for drive in drives)
    taken_over = sum(drive.takeover_frames for drive in drives)
    driven = math.fsum(drive.laps for drive in drives)
    return Performance(
        laps=_mean_laps(drives),
        # fsum is exact, so that the order of the drives cannot show in the last digit
        damage_per_lap=_ratio(math.fsum(drive.damage for drive in drives), driven),
        steering_mse=_ratio(math.fsum(drive.squared_error_sum for drive in drives), measured),
        takeover=taken_over / frames,
        takeover_length=_ratio(taken_over, sum(drive.takeovers for drive in drives)),
        switches_per_lap=_ratio(sum(drive.switches for drive in drives), driven),
        off_road=sum(drive.off_road for drive in drives) / len(drives),
        drives=len(drives),
        frames=frames,
        measuring_queries=measured,
    )


def summarise(outcomes: Iterable[Outcome]) -> dict[str, dict[str, dict[str, float | None]]]:
    """The metrics by strategy and condition, for JSON: {"naive": {"no_traffic": {"laps": ...}}}.

    Raises:
        ValueError: no drives.
    """
    groups: dict[tuple[str, str], list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        groups[str(outcome.strategy), condition(outcome)].append(outcome)
    if not groups:
        raise ValueError("there are no drives, expected at least one")
    summary: dict[str, dict[str, dict[str, float | None]]] = defaultdict(dict)
    for (strategy, where), drives in sorted(groups.items()):
        summary[strategy][where] = asdict(measure(drives))
    return dict(summary)


def condition(outcome: Outcome) -> str:
    """One of CONDITIONS."""
    return CONDITIONS[outcome.traffic > 0]


def _mean_laps(drives: Sequence[Outcome]) -> float:
    by_track: dict[str, list[float]] = defaultdict(list)
    for drive in drives:
        # a drive ends with the frame that completes the last lap, a little behind the line
        by_track[drive.track].append(min(drive.laps, LAPS))
    means = [math.fsum(laps) / len(laps) for laps in by_track.values()]
    return math.fsum(means) / len(means)


def _ratio(part: float, whole: float) -> float | None:
    return part / whole if whole > 0 else None
