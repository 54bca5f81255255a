"""Numbers as they stand in the report."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from pipeline.driving.metrics import CONDITIONS
from pipeline.evaluation.statistics import Estimate
from pipeline.metric import Metric

NOTHING = "-"
"""stands where there is no number"""


def _written(form: Callable[[float], str]) -> Callable[[float | None], str]:
    return lambda value: NOTHING if value is None or math.isnan(value) else form(value)


@dataclass(frozen=True)
class Form:
    """How a metric is written: None and NaN as NOTHING."""

    value: Callable[[float | None], str]
    difference: Callable[[float], str]


FORMS = {
    # so that 2.999 laps do not read as three
    "rounded down": Form(
        _written(lambda value: f"{math.floor(100 * value + 1e-6) / 100:.2f}"), "{:+z.2f}".format
    ),
    "share": Form(_written(lambda value: f"{100 * value:.1f} %"), lambda gap: f"{100 * gap:+z.1f}"),
    "amount": Form(
        _written(lambda value: f"{value:.3g}" if value < 1000 else f"{value:,.0f}"),
        "{:+z.2g}".format,
    ),
    "ratio": Form(_written("{:.2f}".format), "{:+z.2f}".format),
    "count": Form(_written(lambda value: f"{round(value):,}"), "{:+,.0f}".format),
}
"""Of `metric.Metric`."""
laps, share, count = (FORMS[form].value for form in ("rounded down", "share", "count"))


def written(metric: Metric, value: float | None) -> str:
    """A value of a metric."""
    return FORMS[metric.form].value(value)


def in_condition(condition: str) -> str:
    """Where a drive was, in words."""
    return CONDITIONS.get(condition, condition)


def pair(parts: Iterable[str]) -> str:
    """What stands in a cell of a table: of each condition."""
    return " / ".join(parts)


def seeds_in_words(seeds: Sequence[int]) -> str:
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


def table(header: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> str:
    """A markdown table whose first `words` columns are text, and the others numbers."""
    rule = ["---"] * words + ["---:"] * (len(header) - words)
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, rule, *rows])
