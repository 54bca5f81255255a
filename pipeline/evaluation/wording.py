"""Numbers as they stand in the report."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from pipeline.evaluation.statistics import Estimate

NOTHING = "-"
"""stands where there is no number"""
CONDITION_WORDS = {"no_traffic": "without traffic", "traffic": "with traffic"}


def laps(value: float | None) -> str:
    """Rounded down, so that 2.999 laps do not read as three."""
    return NOTHING if value is None else f"{math.floor(100 * value + 1e-6) / 100:.2f}"


def share(value: float | None) -> str:
    """Per cent, with one decimal."""
    return NOTHING if value is None else f"{100 * value:.1f} %"


def amount(value: float | None) -> str:
    """Three significant digits: damage per lap, steering MSE."""
    if value is None:
        return NOTHING
    return f"{value:.3g}" if value < 1000 else f"{value:,.0f}"


def ratio(value: float | None) -> str:
    """Two decimals: AUROC."""
    return NOTHING if value is None else f"{value:.2f}"


def count(value: int) -> str:
    """With thousands apart."""
    return f"{value:,}"


@dataclass(frozen=True)
class Form:
    """How a metric is written."""

    value: Callable[[float | None], str]
    difference: Callable[[float], str]


FORMS = {
    "rounded down": Form(laps, "{:+z.2f}".format),
    "share": Form(share, lambda gap: f"{100 * gap:+z.1f}"),
    "amount": Form(amount, "{:+z.2g}".format),
}
"""Of `metric.Metric`."""


def seeds_in_words(seeds: list[int]) -> str:
    """In the order given."""
    return f"seed{'s' if len(seeds) > 1 else ''} {', '.join(map(str, seeds))}"


def interval(found: Estimate | None, form: Callable[[float], str]) -> str:
    """A value with its 95 % interval."""
    if found is None:
        return NOTHING
    return f"{form(found.value)} [{form(found.low)}, {form(found.high)}]"


def brief_interval(found: Estimate | None, form: Callable[[float], str]) -> str:
    """The same, and the value alone where both ends read as it does: most cells of a table."""
    if found is not None and form(found.low) == form(found.value) == form(found.high):
        return form(found.value)
    return interval(found, form)


def table(header: list[str], rows: list[list[str]], words: int = 1) -> str:
    """A markdown table whose first `words` columns are text, and the others numbers."""
    rule = ["---"] * words + ["---:"] * (len(header) - words)
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, rule, *rows])
