"""The report's first screen says how many labels each strategy needs, where there are label curves."""

import math
from dataclasses import replace
from itertools import combinations

import pytest

from pipeline.evaluation.experiment import Experiment
from pipeline.inspection.canvas import png
from pipeline.report.label_curves import label_curves
from pipeline.report.labels import needed
from tests.evaluation.made_up import GROWING, experiment, without
from tests.evaluation.made_up_curves import SPECS, curves
from tests.report.drawn import curves as points
from tests.report.drawn import names, panels
from tests.report.rendered import report, section

BEST = "dagger4000"
SHARES = {
    **{run: 0.9 for run in SPECS},
    "safedagger500": 0.6,
    "safedagger1000": 0.85,
    "dagger500": 0.4,
    "dagger1000": 0.5,
    "dagger2000": 0.85,
    "supervised500": 0.4,
    "supervised1000": 0.4,
    "supervised2000": 0.4,
    "training": 0.5,
}


@pytest.fixture(scope="module")
def made_up() -> Experiment:
    return curves(SHARES)


def test_for_each_way_to_collect_the_fewest_labels_that_are_enough(made_up: Experiment) -> None:
    assert [*needed(made_up, BEST)] == [
        "SafeDAgger: 2,000 in the loop, 10,400 in all; undecided: SafeDAgger, 1,000 labels",
        "DAgger: none with fewer; undecided: DAgger, 2,000 labels",
        "DAgger that asks seldom: 2,000 in the loop, 4,800 in all",
        "supervised: none of those measured",
        "more training: none of those measured",
        "SafeDAgger, from anywhere: 1,000 in the loop, 9,400 in all",
        "DAgger, from anywhere: 1,000 in the loop, 3,800 in all",
        "SafeDAgger that learns how far: 1,000 in the loop, 9,400 in all",
        "SafeDAgger that asks seldom: 2,000 in the loop, 10,400 in all",
        "SafeDAgger that asks seldom with a quarter of D_safe: 1,000 in the loop, 5,200 in all",
        "SafeDAgger with audits: 1,000 in the loop, 9,400 in all",
        "SafeDAgger with audits for D_safe: 1,000 in the loop, 3,800 in all",
    ]


def test_the_report_begins_with_the_label_curves(made_up: Experiment) -> None:
    text = report(experiment({"safedagger": GROWING}), curves=made_up)
    first = section(text, "How many labels it takes")
    assert text.index("## How many labels it takes") < text.index("## Claims of the paper")
    assert first.index("![Success against labels](figures/labels.png)") < first.index("| Run |")
    row = next(line for line in first.splitlines() if line.startswith("| SafeDAgger, 500 labels |"))
    # of 40 drives 24 succeed, over 1,000 m each, and 16 leave the road
    success = "60.0 % [43.3 %, 75.1 %]"
    assert row.startswith(
        f"| SafeDAgger, 500 labels | 80, 1 | 500 | 8,900 | {success} / {success} | 40 ["
    )
    assert "| no, -30.0 [" in row and row.endswith(" | 3 | 30 | 16.7 |")
    before = "| before the loop | 80, 1 | 0 | 2,800 | 50.0 % "
    assert before in first and "There is one seed, 0, so" in first
    assert "- Label curves: " not in text  # driven at their ends alone
    assert "| DAgger, 500 labels | 0 | 40.0 % [24.9 %, 56.7 %] /" in section(
        text, "Reliability, by seed"
    )


def test_what_the_ledgers_do_not_tell_is_a_dash_and_what_is_not_there_is_named(
    made_up: Experiment,
) -> None:
    partly = without(made_up, run=[BEST, "training"], iteration=3)
    partly = replace(partly, ledgers=partly.ledgers.assign(calls=math.nan, failures=math.nan))
    text = report(experiment({"safedagger": GROWING}), curves=partly)
    row = next(line for line in text.splitlines() if line.startswith("| SafeDAgger, 500 labels |"))
    assert row.endswith(" | undecided | - | - | - |")
    missing = section(text, "What is missing")
    assert "- Label curves: DAgger, 4,000 labels, seed 0: no iteration 3." in missing
    for found, bands in ((made_up, 1), (partly, 0)):
        (legend,) = label_curves(found, BEST).legends
        told = [text.get_text() for text in legend.get_texts()]
        assert told.count("at most 5 points below DAgger, 4,000 labels") == bands


def test_without_label_curves_the_report_is_as_it_was() -> None:
    text = report(experiment({"safedagger": GROWING}))
    assert "labels.png" not in text and "How many labels" not in text
    assert "label curves" not in text.lower()
    assert text.startswith("# SafeDAgger: the result\n\nOf the ")


def test_the_picture_shows_success_against_labels(made_up: Experiment) -> None:
    figure = label_curves(made_up, BEST)
    assert png(figure) == png(label_curves(made_up, BEST))
    shown = panels(figure)
    assert [title for title, _ in shown] == [
        "Success: naive, no traffic",
        "Success: naive, traffic",
    ]
    for axes in shown.values():
        assert axes.get_xscale() == "log"
        lines = {name.removesuffix(" (traffic)"): line for name, line in points(axes).items()}
        assert lines["SafeDAgger"] == [(500, 0.6), (1000, 0.85), (2000, 0.9)]
        assert lines["supervised"] == [(520, 0.4), (1000, 0.4), (2000, 0.4)]
        assert {y for _, y in lines["more training"]} == {0.5}
        (band,) = axes.patches
        assert band.get_extents().transformed(axes.transData.inverted()).y0 == pytest.approx(0.85)
        assert names(axes).keys() == lines.keys()
        for one, other in combinations(names(axes).values(), 2):
            assert not one.overlaps(other)
            assert one.x1 <= figure.bbox.x1
