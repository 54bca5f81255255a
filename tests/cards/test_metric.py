"""A metric that is said once is in every table and figure and on every card that it is shown in."""

from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.summary import headline
from pipeline.metric import QUALITY, SPENT, Metric
from pipeline.report.figures import driving
from tests.evaluation.made_up import FIRST, GROWING, SLOW, drives, experiment
from tests.report.drawn import panels, words
from tests.report.rendered import report, rows, section

SPEED = Metric("Frames per lap", "frames", "amount", "frames", "laps")
BOTH = ("tables", "figures", "cards", "dvc")


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(METRICS, "frames_per_lap", SPEED)


@pytest.mark.usefixtures("added")
def test_in_tables_and_figures() -> None:
    made_up = experiment({"safedagger": GROWING, "dagger": SLOW})
    found = rows(section(report(made_up), "In numbers"), "Frames per lap, naive")
    assert found["SafeDAgger", "0"][0] == "500 / 667"
    figure = driving(made_up, ["safedagger", "dagger"])
    assert ("Frames per lap: naive, no traffic", "iteration") in panels(figure)
    assert "Frames per lap 333: safe, no traffic" in words(figure)


@pytest.mark.usefixtures("added")
def test_on_cards(make_cards: Callable[..., Path]) -> None:
    card = (make_cards() / "models" / "primary_0.md").read_text()
    assert "name: Frames per lap [frames]" in card
    assert "| Frames per lap [frames] |" in card and "| 333 |" in card


def test_dvc_shows_it_where_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    once = Metric("Frames per lap", "frames", "amount", "frames", "laps", shown=BOTH)
    monkeypatch.setitem(METRICS, "frames_per_lap", once)
    assert headline(drives(FIRST), METRICS)["safe"]["frames_per_lap"] == pytest.approx(1000 / 3)


def test_of_safety_policies_and_of_what_was_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    unlike = Metric("Unlike", "share", "share", "recall", statistic="mean")
    monkeypatch.setitem(QUALITY, "unlike", unlike)
    selected = Metric("Selected so far", "frames", "count", "frames_selected", statistic="mean")
    monkeypatch.setitem(SPENT, "frames_selected", selected)
    text = section(report(experiment({"safedagger": [FIRST, FIRST]})), "In numbers")
    assert rows(text, "Unlike")["SafeDAgger", "0"][-1] == "- / -"
    assert rows(text, "Selected so far")["SafeDAgger", "1"][-1] == "1,000"
