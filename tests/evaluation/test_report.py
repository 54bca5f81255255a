"""The report says what the data says, for better or worse."""

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pipeline.evaluation.expectations import check_expectations
from pipeline.evaluation.report import render_report
from pipeline.evaluation.results import STRATEGIES, Results, read_results
from pipeline.evaluation.summary import CONDITIONS
from pipeline.evaluation.wording import amount, laps, share
from pipeline.policies.strategies import Strategy
from stages.report import app
from tests.evaluation.sample import CARS, GOOD, write_run

PERFECT = {(strategy, cars): ((3.0, 0, 0.1),) * 4 for strategy, cars in GOOD}


def run(folder: Path, **changes: Any) -> Results:
    """A run in which some cases went otherwise: naive_0=..., safe_40=..."""
    plan = {
        (strategy, cars): changes.get(f"{strategy}_{cars}", levels)
        for (strategy, cars), levels in GOOD.items()
    }
    return read_results(write_run(folder, plan), 3)


def report(results: Results) -> str:
    return render_report(results, progress="p.png", pictures={"Training tracks": "t.png"})


def section(text: str, title: str) -> str:
    return text.split(f"## {title}\n")[1].split("\n## ")[0]


def test_the_tables_hold_the_numbers_of_their_inputs(tmp_path: Path) -> None:
    results = run(tmp_path)
    rows = section(report(results), "Driving on the test tracks").splitlines()
    for step in results.iterations:
        row = next(line for line in rows if line.startswith(f"| {step.number} |"))
        for strategy in STRATEGIES:
            cells = [step.driving[strategy][where] for where in CONDITIONS]
            assert " / ".join(laps(cell.laps) for cell in cells) in row
            assert " / ".join(amount(cell.damage_per_lap) for cell in cells) in row
            assert " / ".join(amount(cell.steering_mse) for cell in cells) in row
        takeovers = [step.driving[Strategy.SAFE][where].takeover for where in CONDITIONS]
        assert row.endswith(f"| {' / '.join(map(share, takeovers))} |")


def test_the_ledger_is_cumulated_without_the_demonstrations(tmp_path: Path) -> None:
    ledger = section(report(run(tmp_path)), "What it cost")
    assert "| D_0 | 3,600 | 3,600 | 100.0 % | 3,600 | 3,600 | - | - | - |" in ledger
    assert "| D_safe | 1,201 | 1,201 | 100.0 % | - | - | - | - | - |" in ledger
    assert "| 1 | 3,610 | 1,100 | 30.5 % | 1,100 | 4,700 | 3,610 | 1,100 | 30.5 % |" in ledger
    assert "| 3 | 3,630 | 500 | 13.8 % | 500 | 6,000 | 10,860 | 2,400 | 22.1 % |" in ledger


def test_the_safety_policy_on_held_out_frames_and_in_the_next_rollout(tmp_path: Path) -> None:
    rows = section(report(run(tmp_path)), "The safety policy").splitlines()
    assert any(row.startswith("| 0 | 0.0025 | 0.90 / 0.78 | 60.0 % / 48.0 % |") for row in rows)
    assert any(row.startswith("| 3 | 0.0025 | 0.90 / - | 60.0 % / - |") for row in rows)


def test_the_first_screen(tmp_path: Path) -> None:
    title, headline, picture, cost, *_ = report(run(tmp_path)).split("\n\n")
    assert title.startswith("# ")
    assert "1.63 of 3 laps without traffic and 0.73 with traffic after supervised" in headline
    assert "after iteration 3 it completed 3.00 and 2.93" in headline
    assert "asked 2,400 times, in 22.1 % of the frames" in headline
    assert "All 4 [expectations](#expectations) hold." in headline
    assert picture.endswith("(p.png)")
    for number in ("2,400 queries", "10,860 frames", "3,600 for D_0", "1,201 for D_safe"):
        assert number in cost
    assert "8,460 frames of rollouts" in cost


def test_the_words_follow_the_data(tmp_path: Path) -> None:
    text = report(read_results(write_run(tmp_path, PERFECT), 3))
    assert "after iteration 3 it completed all of them in both conditions" in text
    assert "Of 4 [expectations](#expectations), 4 failed." in text
    assert section(text, "Where the result falls short").startswith("\nNowhere: after iteration 3")


def test_shortfalls_are_listed_by_track_with_their_cause(tmp_path: Path) -> None:
    text = section(report(run(tmp_path)), "Where the result falls short")
    assert "3 of 12 cases" in text
    assert "| naive, with traffic, yew | 2.80 | 0.536 | 2 of 2 | 0 of 2 |" in text
    assert "| naive, with traffic, spruce | 3.00 | 0.5 | 0 of 2 | 0 of 2 |" in text
    assert "safe" not in text.split("\n\n")[1]
    assert "2 drives ended by leaving the road, 0 stood still" in text
    assert "recognised 44.0 % of the truly unsafe frames, against 60.0 %" in text


def test_a_run_can_meet_every_expectation(tmp_path: Path) -> None:
    assert all(check.holds for check in check_expectations(run(tmp_path)))


@pytest.mark.parametrize(
    ("number", "changes", "evidence"),
    [
        # pi_0 is perfect, so that nothing can be better than it either
        (
            0,
            {"naive_0": ((3.0, 0, 0),) * 4, f"naive_{CARS}": ((3.0, 0, 0),) * 4},
            "0 of 6 cases",
        ),
        (
            1,
            {f"safe_{CARS}": ((0.2, 3, 0.4), *GOOD["safe", CARS][1:])},
            "drives 0.43 laps (naive: 0.73)",
        ),
        # further, but never on the road to the end: not less often off it
        (
            1,
            {"safe_0": ((2.0, 0, 0.2), *GOOD["safe", 0][1:])},
            "leaves in 100.0 % of the drives (naive: 100.0 %)",
        ),
        (
            2,
            {"naive_0": (*GOOD["naive", 0][:3], (1.0, 0, 0))},
            "without traffic 1.63 laps before, 1.23 after",
        ),
        (
            3,
            {"safe_0": (*GOOD["safe", 0][:3], (3.0, 0, 0.2))},
            "without traffic 20.0 % before, 20.0 % after",
        ),
    ],
)
def test_each_expectation_can_fail(
    tmp_path: Path, number: int, changes: dict[str, Any], evidence: str
) -> None:
    results = run(tmp_path, **changes)
    check = check_expectations(results)[number]
    assert not check.holds
    assert evidence in check.evidence
    assert f"| {check.claim} | **does not hold** | {check.evidence} |" in report(results)


def test_just_short_of_three_laps_does_not_read_as_three() -> None:
    assert laps(2.999) == "2.99"
    assert laps(3.0) == "3.00"
    assert laps(0.29) == "0.29"


def arguments(folder: Path) -> list[str]:
    """Of the stage, on a run in `folder`."""
    write_run(folder / "metrics")
    pictures = [folder / "errors.png", folder / "frames.png"]
    for picture in pictures:
        picture.write_bytes(b"drawn")
    options = {
        "--metrics": folder / "metrics",
        "--iterations": 3,
        "--errors": pictures[0],
        "--frames": pictures[1],
        "--output": folder / "cards" / "report.md",
        "--figures": folder / "cards" / "figures",
    }
    return [str(word) for pair in options.items() for word in pair]


def test_the_stage_writes_all_or_refuses(tmp_path: Path) -> None:
    given, output = arguments(tmp_path), tmp_path / "cards" / "report.md"
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines()[-1].startswith(f"{output}: ")
    names = {file.name for file in (tmp_path / "cards" / "figures").iterdir()}
    assert names == {"progress.png", "training.png", "test.png"}
    shown = [*(f"figures/{name}" for name in names), "../errors.png", "../frames.png"]
    assert all(f"]({place})" in output.read_text() for place in shown)

    again = CliRunner().invoke(app, given)
    assert isinstance(again.exception, FileExistsError)
    assert str(again.exception) == f"{output}: exists already, expected a new path"


@pytest.mark.parametrize("missing", ["metrics/rollout_safedagger_3.json", "frames.png"])
def test_the_stage_writes_nothing_where_something_is_missing(tmp_path: Path, missing: str) -> None:
    given = arguments(tmp_path)
    (tmp_path / missing).unlink()
    result = CliRunner().invoke(app, given)
    assert isinstance(result.exception, FileNotFoundError)
    assert missing in str(result.exception)
    assert not (tmp_path / "cards").exists()
