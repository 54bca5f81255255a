"""The report of a comparison says what the experiment says, and what it lacks."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pipeline.evaluation.comparison import Cell, estimate
from pipeline.evaluation.comparison_report import render_comparison
from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.results import SafetyQuality
from pipeline.evaluation.summary import condition
from pipeline.evaluation.verdicts import verdicts
from pipeline.evaluation.wording import laps
from pipeline.policies.strategies import Strategy
from stages.compare import TITLES, app
from tests.evaluation.made_up import GOOD, GROWING, SLOW, ending, experiment, scattered
from tests.evaluation.sample import write_run


def report(made_up: Experiment, thresholds: dict[float, Experiment] | None = None) -> str:
    return render_comparison(made_up, thresholds or {}, {"Driving": "figures/driving.png"})


def section(text: str, title: str) -> str:
    return text.split(f"## {title}\n")[1].split("\n## ")[0]


def rows(text: str, header: str) -> dict[tuple[str, str], list[str]]:
    """Of the table that has a column of this name: by run and iteration, the other cells."""
    (found,) = (part for part in text.split("\n\n") if f"| {header} |" in part.splitlines()[0])
    lines = [line.strip("| ").split(" | ") for line in found.splitlines()[2:]]
    return {(run, iteration): cells for run, iteration, *cells in lines}


def changed(made_up: Experiment, change: Callable[[Step], Step]) -> Experiment:
    return Experiment({key: change(step) for key, step in made_up.steps.items()})


def optimal_too(step: Step) -> Step:
    safe = [drive for drive in step.drives if drive.strategy == Strategy.SAFE]
    optimal = [replace(drive, strategy=Strategy.OPTIMAL, laps=2.5) for drive in safe]
    return replace(step, drives=step.drives + optimal)


TABLES = {
    "Laps, naive": 3,
    "Damage per lap, naive": 3,
    "Steering MSE, naive": 4,
    "Takeover, safe": 2,
    "Switches per lap, safe": 2,
    "Frames of a takeover, safe": 2,
    "Queries so far": 3,
}


@pytest.mark.parametrize("header", TABLES)
def test_every_run_and_iteration_has_its_row(header: str) -> None:
    made_up = experiment({run: levels for run, levels in GOOD.items() if run != "dagger"})
    found = rows(report(made_up), header)
    assert list(found) == [(RUNS[run], str(i)) for run in RUNS if run != "dagger" for i in range(4)]
    assert {len(cells) for cells in found.values()} == {TABLES[header]}


def test_the_first_screen_compares_laps_and_queries() -> None:
    title, headline, basis, claims, *_ = report(experiment(GOOD)).split("\n\n")
    assert title.startswith("# ")
    assert (
        "After iteration 3 of SafeDAgger, at 7,000 queries, the naive primary completed 3.00 "
        "[3.00, 3.00] of 3 laps without traffic and 3.00 [3.00, 3.00] with traffic." in headline
    )
    assert (
        "After iteration 3 of DAgger, at 35,000 queries (5.0 times SafeDAgger's), the naive "
        "primary completed 2.40 [2.40, 2.40] of 3 laps without traffic and 2.10" in headline
    )
    assert "of supervised learning, at 35,000 queries (5.0 times SafeDAgger's)" in headline
    assert basis.startswith("**Basis.**")
    assert claims.startswith("| Claim of the paper | Verdict | Numbers |")


def test_the_first_screen_follows_the_data() -> None:
    dear = [replace(level, queries=14_000) for level in GROWING]
    worse = report(experiment({"safedagger": ending(dear, laps=(1.0, 0.5)), "dagger": SLOW[:2]}))
    headline = worse.split("\n\n")[1]
    assert "SafeDAgger, at 42,000 queries, the naive primary completed 1.00" in headline
    assert "iteration 1 of DAgger, at 15,000 queries (0.4 times SafeDAgger's)" in headline
    assert "supervised" not in headline
    others = report(experiment({"dagger_budget": SLOW})).split("\n\n")[1]
    assert others == "There are no results of SafeDAgger, DAgger or supervised."


def test_every_verdict_stands_with_its_numbers() -> None:
    made_up = experiment({**GOOD, "supervised": GROWING})
    text = report(made_up)
    judged = verdicts(made_up)
    assert {each.verdict for each in judged} > {"holds"}
    for each in judged:
        words = each.verdict if each.verdict == "holds" else f"**{each.verdict}**"
        assert f"| {each.claim} | {words} | {each.evidence} |" in text


def test_what_it_rests_on() -> None:
    basis = report(experiment(GOOD, seeds=2, starts=3)).split("\n\n")[2]
    assert "Seeds: 0, 1. Test tracks: spruce, willow, yew. Starts on each: 3." in basis
    assert "Traffic: 40 cars. 2,016 drives in all." in basis
    assert "`make experiment`" in basis
    assert "one seed" not in basis
    assert "With one seed, no interval" in report(experiment(GOOD)).split("\n\n")[2]


def test_laps_have_their_intervals_in_both_conditions() -> None:
    made_up = changed(experiment({"dagger": scattered(SLOW)}), optimal_too)
    naive, safe, optimal = rows(report(made_up), "Laps, naive")["DAgger", "2"]
    expected = []
    for where in ("no_traffic", "traffic"):
        one = estimate(made_up, "laps", Cell("dagger", (2,), Strategy.NAIVE, (where,)))
        assert one and one.low < one.high
        expected.append(f"{laps(one.value)} [{laps(one.low)}, {laps(one.high)}]")
    assert naive == " / ".join(expected)
    assert safe.startswith("2.70 [")
    assert optimal == "2.50 [2.50, 2.50] / 2.50 [2.50, 2.50]"


def test_every_metric_is_in_its_table() -> None:
    def driven(step: Step) -> Step:
        safe = [d for d in step.drives if d.strategy == Strategy.SAFE]
        naive = [replace(d, damage=3 * d.laps) for d in step.drives if d not in safe]
        switched = [replace(d, takeovers=20, switches=39) for d in safe]
        return replace(step, drives=naive + switched)

    text = report(changed(experiment({"dagger": SLOW}, starts=2), driven))
    same = "{0} [{0}, {0}] / {1} [{1}, {1}]".format
    first = ("DAgger", "0")
    assert rows(text, "Damage per lap, naive")[first][:2] == [same(3, 3), same(0, 0)]
    assert rows(text, "Steering MSE, naive")[first] == [
        same(0.02, 0.03),
        same(0.02, 0.03),
        "6,000 / 6,000",
        "5,520 / 4,800",
    ]
    assert rows(text, "Takeover, safe")[first] == [same("8.0 %", "20.0 %"), "- / -"]
    assert rows(text, "Switches per lap, safe")[first][0] == same(13, 13)
    assert rows(text, "Frames of a takeover, safe")[first][0] == same(4, 10)


def test_the_cost_is_that_of_the_loop_and_the_mean_over_the_seeds() -> None:
    def dearer(step: Step) -> Step:
        driven = 1000 * step.iteration + 100 * step.seed
        trained = 2000 + 10 * step.iteration
        return replace(
            step, ledger=replace(step.ledger, frames_driven=driven, frames_trained=trained)
        )

    found = rows(
        report(changed(experiment({"safedagger": GROWING}, seeds=2), dearer)), "Queries so far"
    )
    assert found["SafeDAgger", "0"] == ["0", "0", "2,000"]
    assert found["SafeDAgger", "1"] == ["3,000", "1,050", "2,010"]
    assert found["SafeDAgger", "3"] == ["7,000", "6,150", "2,030"]


def test_figures_are_shown_under_their_titles() -> None:
    assert "Driving:\n\n![Driving](figures/driving.png)" in report(experiment(GOOD))


def test_the_thresholds_are_side_by_side() -> None:
    def told_apart(share: float | None) -> Callable[[Step], Step]:
        return lambda step: replace(step, held_out=SafetyQuality(None, None, None, share, None))

    first, last = (
        experiment({"safedagger": GROWING[:1]}, seeds=2),
        experiment({"safedagger": GROWING[3:]}),
    )
    found = section(
        report(
            experiment(GOOD),
            {0.000625: changed(first, told_apart(0.417)), 0.04: changed(last, told_apart(None))},
        ),
        "Other thresholds",
    )
    strict, lax = found.strip().splitlines()[-2:]
    assert strict.startswith("| 0.000625 | 0, 1 | 41.7 % | 3.00 [3.00, 3.00] / 3.00")
    assert "| 8.0 % [8.0 %, 8.0 %] / 20.0 % [20.0 %, 20.0 %] |" in strict
    assert lax.startswith("| 0.04 | 0 | - | 3.00")
    assert "| 2.0 % [2.0 %, 2.0 %] / 5.0 % [5.0 %, 5.0 %] |" in lax


def test_nothing_is_missing_of_a_whole_comparison() -> None:
    whole = report(changed(experiment(GOOD, seeds=2), optimal_too))
    assert section(whole, "What is missing").strip() == "Nothing."
    assert "no drives with safety policies of other tau" in section(whole, "Other thresholds")


def test_what_is_missing_is_named() -> None:
    table = {run: levels for run, levels in GOOD.items() if run != "supervised"}
    steps = dict(changed(experiment(table, seeds=2), optimal_too).steps)
    del steps[1, "dagger", 2], steps[1, "dagger", 3]
    cut = steps[0, "safedagger_max", 1]
    kept = [d for d in cut.drives if d.strategy != "safe" or d.traffic == 0 or d.track != "yew"]
    steps[0, "safedagger_max", 1] = replace(cut, drives=kept)
    for i in range(4):
        for seed in range(2):
            step = steps[seed, "safedagger_rising", i]
            drives = [d for d in step.drives if d.strategy != Strategy.OPTIMAL]
            steps[seed, "safedagger_rising", i] = replace(step, drives=drives)
    assert section(report(Experiment(steps)), "What is missing").strip().splitlines() == [
        "- supervised: no results.",
        "- DAgger, seed 1: no iteration 2, 3.",
        "- SafeDAgger, 1 s ahead (max), seed 0, iteration 1: 8 of 12 drives of safe, with traffic.",
        "- SafeDAgger, rising tau: no drives with the optimal safety policy.",
    ]


def test_a_condition_that_nobody_met_is_missing() -> None:
    quiet = changed(
        experiment({"dagger": SLOW[:1]}),
        lambda step: replace(step, drives=[d for d in step.drives if condition(d) == "no_traffic"]),
    )
    text = report(quiet)
    assert "Traffic: no cars." in text
    assert "- DAgger, seed 0, iteration 0: 0 of 12 drives of naive, with traffic." in text
    assert rows(text, "Laps, naive")["DAgger", "0"][0] == "2.00 [2.00, 2.00] / -"


def test_equal_experiments_give_equal_bytes() -> None:
    """In whatever order they were read; here with a drive missing in each step."""
    made_up = changed(
        experiment({"dagger": scattered(SLOW), "safedagger": scattered(GROWING)}, seeds=2),
        lambda step: replace(step, drives=step.drives[1:]),
    )
    backwards = Experiment(dict(reversed(made_up.steps.items())))
    assert report(made_up) == report(made_up) == report(backwards)
    assert report(made_up).count(" drives of naive, without traffic.") == 16


def write_metrics(metrics: Path) -> list[str]:
    """Two runs on seed 0, and a threshold; the options that compare them."""
    folder = write_run(metrics / "seed_0")
    for file in sorted(folder.glob("*_safedagger_?.*")):
        shutil.copy(file, folder / file.name.replace("safedagger", "dagger"))
    for kind in ("drives_{}.csv", "safety_{}.json"):
        shutil.copy(folder / kind.format("safedagger_1"), folder / kind.format("tau_01"))
    text = (folder / "safety_tau_01.json").read_text()
    (folder / "safety_tau_01.json").write_text(text.replace("0.0025", "0.01"))
    output, figures = metrics.parent / "cards" / "comparison.md", metrics.parent / "cards" / "png"
    return ["--metrics", str(metrics), "--output", str(output), "--figures", str(figures)]


def test_the_stage_writes_all_or_refuses(tmp_path: Path) -> None:
    arguments = write_metrics(tmp_path / "metrics")
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    output, figures = tmp_path / "cards" / "comparison.md", tmp_path / "cards" / "png"
    assert result.stdout.splitlines() == [f"{output}: 8 steps, 3 figures in {figures}"]
    names = {file.name for file in figures.iterdir()}
    assert names == {"strategies.png", "strategies_takeover.png", "strategies_cost.png"}
    text = output.read_text()
    assert all(f"](png/{name})" in text for name in names)
    assert "| 0.01 | 0 | 20.0 % |" in text

    for path in (output, figures / "optimal.png"):
        path.write_text("precious")
        again = CliRunner().invoke(app, arguments)
        assert isinstance(again.exception, FileExistsError)
        assert path.read_text() == "precious"
        path.unlink()


def test_the_stage_draws_variants_and_the_optimal_safety_policy_where_there_are(
    tmp_path: Path,
) -> None:
    arguments = write_metrics(tmp_path / "metrics")
    folder = tmp_path / "metrics" / "seed_0"
    for file in sorted(folder.glob("*_dagger_?.*")):
        file.rename(folder / file.name.replace("dagger", "safedagger_last"))
    csv = folder / "drives_safedagger_last_2.csv"
    lines = csv.read_text().splitlines()
    csv.write_text(
        "\n".join(
            [*lines, *(line.replace("safe,", "optimal,") for line in lines if ",safe," in line)]
        )
        + "\n"
    )
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert {file.stem for file in (tmp_path / "cards" / "png").iterdir()} == TITLES.keys()


def test_the_stage_writes_nothing_on_bad_metrics(tmp_path: Path) -> None:
    arguments = write_metrics(tmp_path / "metrics")
    (tmp_path / "metrics" / "seed_0" / "safety_tau_01.json").unlink()
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, FileNotFoundError)
    assert [path.name for path in tmp_path.iterdir()] == ["metrics"]
