"""Runs as small as they can be, and the loops that they are unrolled into."""

from typing import Any

from pipeline.loops import loops as unrolled
from pipeline.runs import Comparison

LOOK = {"name": "One", "words": "One.", "colour": "black", "marker": "o", "driven_by": "naive"}
LONG, SHORT = {"seconds": 20}, {"seconds": 4}
ONE: dict[str, Any] = LOOK | {
    "strategy": "safedagger",
    "protocol": "long",
    "queries": [30, 10],
    "samples": [500],
    "tau": [0.1],
}
DAGGER = LOOK | {
    "strategy": "dagger",
    "protocol": "long",
    "frames": [90],
    "sample": [30],
    "samples": [500],
    "tau": [0.1],
}


def loops(**runs: dict[str, Any]) -> dict[str, Any]:
    return unrolled(Comparison.of({"runs": runs, "protocols": {"long": LONG, "short": SHORT}}))
