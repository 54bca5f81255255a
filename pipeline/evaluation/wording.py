"""Numbers as they stand in the report."""

import math

NOTHING = "–"
"""stands where there is no number"""


def laps(value: float) -> str:
    """Rounded down, so that 2.999 laps do not read as three."""
    return f"{math.floor(100 * value + 1e-6) / 100:.2f}"


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


def pair(without: str, with_traffic: str) -> str:
    """Without traffic, and with traffic, in one cell."""
    return f"{without} / {with_traffic}"


def table(header: list[str], rows: list[list[str]]) -> str:
    """A markdown table; the first column is text, the others numbers."""
    rule = ["---", *["---:"] * (len(header) - 1)]
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, rule, *rows])
