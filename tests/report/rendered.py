"""The report of a made-up experiment, and parts of its markdown."""

import re
from typing import Any

from pipeline.evaluation.experiment import Experiment, Tables
from pipeline.evaluation.files import ErrorShares
from pipeline.report.material import Material
from pipeline.report.rendering import Pictures, render_report
from tests.evaluation import written

ERRORS = "How the errors lie around tau"


def report(made_up: Experiment, **changes: Any) -> str:
    """With each seed's errors and nothing else beside the experiment, but for the changes; and with a
    picture for each seed.
    """
    material: dict[str, Any] = {
        "thresholds": Tables(),
        "scratch": Tables(),
        "errors": dict.fromkeys(made_up.seeds, ErrorShares.model_validate(written.ERRORS)),
        "curves": Experiment(specs={}),
        "relied_on": Experiment(specs={}),
        "in_crowd": Experiment(specs={}),
    }
    places = {seed: f"errors/seed_{seed}.png" for seed in made_up.seeds}
    pictures = Pictures(
        result="figures/result.png",
        labels="figures/labels.png",
        figures={"Driving": "figures/driving.png"},
        by_seed=changes.pop("by_seed", {ERRORS: places}),
        tracks={"Training tracks": "figures/training.png"},
    )
    return render_report(Material(made_up, **material | changes), pictures)


def section(text: str, title: str) -> str:
    """What stands under a heading, up to the next of its level or above."""
    (level,) = re.findall(rf"^(##+) {re.escape(title)}$", text, re.MULTILINE)
    rest = text.split(f"\n{level} {title}\n")[1]
    return re.split(rf"\n##{{1,{len(level) - 1}}} ", rest)[0]


def rows(text: str, header: str) -> dict[tuple[str, str], list[str]]:
    """Of the table that has a column of this name: by its first two columns, the other cells."""
    (found,) = (part for part in text.split("\n\n") if f"| {header} |" in part.splitlines()[0])
    lines = [line.strip("| ").split(" | ") for line in found.splitlines()[2:]]
    return {(first, second): cells for first, second, *cells in lines}
