"""How the lines of a figure look, and the legend that says so."""

from collections.abc import Iterable
from typing import Any

from matplotlib.lines import Line2D

from pipeline.evaluation.experiment import RUNS
from pipeline.evaluation.summary import CONDITIONS
from pipeline.rollout.strategies import Strategy

# colours that the colour-blind can tell, of different brightness within a panel, and markers
LOOKS = {
    "supervised": ("black", "D"),
    "dagger": ("#d55e00", "o"),
    "dagger_budget": ("#e69f00", "^"),
    "safedagger": ("#0b4f8a", "s"),
    "safedagger_last": ("#1a8a5a", "<"),
    "safedagger_max": ("#cc79a7", ">"),
    "safedagger_rising": ("#88ccee", "v"),
    Strategy.SAFE: ("#0b4f8a", "s"),
    Strategy.OPTIMAL: ("#e69f00", "D"),
}
DASHES = {"no_traffic": "-", "traffic": (0, (4, 2))}
LABELS = {"no_traffic": "no traffic", "traffic": "traffic"}
NAMES = RUNS | {Strategy.SAFE: "safe", Strategy.OPTIMAL: "optimal"}  # in the legend
SIZE = 5.0  # [points] of a marker


def look(colour: str, marker: str, where: str) -> dict[str, Any]:
    """Of a line in one of CONDITIONS, for matplotlib."""
    line = {"color": colour, "marker": marker, "markersize": SIZE, "linestyle": DASHES[where]}
    return line | {"markerfacecolor": colour if where == "no_traffic" else "white"}


def legend(keys: Iterable[str]) -> list[Line2D]:
    """What colours, dashes and bars stand for: each of the keys, of LOOKS, once."""
    looks = {key: look(*LOOKS[key], "no_traffic") for key in keys}
    return [
        *(Line2D([], [], label=NAMES[key], **style) for key, style in looks.items()),
        *(Line2D([], [], label=LABELS[c], **look("0.4", "o", c)) for c in CONDITIONS),
        Line2D([], [], color="0.4", marker="|", ms=12, linestyle="", label="95 % interval"),
    ]
