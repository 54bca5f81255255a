"""The report says what the experiment says, for better or worse, and what it lacks."""

from dataclasses import replace

from pipeline.claims.verdicts import verdicts
from pipeline.evaluation.experiment import HELD_OUT, Experiment, Tables
from pipeline.evaluation.reading import SCRATCH, WARM
from pipeline.report.rendering import runs
from tests.evaluation.made_up import (
    FULL,
    GOOD,
    GROWING,
    SLOW,
    SPECS,
    ending,
    experiment,
    judged,
    reckoned,
    scattered,
    undriven,
    with_optimal,
    without,
)
from tests.report.rendered import ERRORS, report, rows, section

ALONE = {"safedagger": GROWING}
RUNS = (WARM, SCRATCH)


def named(made_up: Experiment, run: str) -> Tables:
    """All its steps, as those of this run."""
    return Tables(
        drives=made_up.drives.assign(run=run, step=run), quality=made_up.quality.assign(run=run)
    )


def test_every_verdict_stands_with_its_numbers() -> None:
    made_up = experiment({**GOOD, "supervised": GROWING})
    text = section(report(made_up), "Claims of the paper")
    found = verdicts(made_up)
    assert {each.verdict for each in found} > {"holds"}
    for number, each in enumerate(found, 1):
        words = each.verdict if each.verdict == "holds" else f"**{each.verdict}**"
        assert f"| {number}. {each.claim} | {words} | {each.observed} |" in text
        assert f"\n{number}. {each.evidence}\n" in text


def test_sections_come_in_order_and_without_runs_they_are_left_out() -> None:
    def headings(text: str) -> list[str]:
        return [line.lstrip("# ") for line in text.splitlines() if line.startswith("##")]

    made_up = experiment(GOOD)
    tau = named(experiment({"safedagger": GROWING[:1]}), "0.01")
    pairs = Tables.joined([named(experiment({"safedagger": GROWING[:1]}), r) for r in RUNS])
    every = [
        "Claims of the paper",
        "Over the iterations",
        "In numbers",
        "Driving on the test tracks",
        "What it cost",
        "The safety policies",
        "Other thresholds",
        "Warm start or from scratch",
        "Which errors are safe",
        "Track by track, after the last iteration",
        "Where SafeDAgger falls short",
        "Pictures",
        "What is missing",
    ]
    assert headings(report(made_up, thresholds=tau, scratch=pairs)) == every
    absent = {every[5], every[6], every[7], every[8], every[10]}
    dagger = headings(report(experiment({"dagger": SLOW}), errors={}))
    assert dagger == [title for title in every if title not in absent]


def test_shortfalls_are_those_of_the_last_iteration_on_every_seed() -> None:
    made_up = experiment({"safedagger": ending(GROWING, laps=(3.0, 2.0)), "dagger": SLOW}, seeds=2)
    text = section(report(made_up), "Where SafeDAgger falls short")
    assert "In the drives after iteration 3: in 6 of 24 cases" in text
    assert "| 1 | naive, with traffic, yew | 2.00 | 0 | 4 of 4 | 0 of 4 | 0 of 4 |" in text
    perfect = section(
        report(experiment({"safedagger": [*GROWING, FULL]})), "Where SafeDAgger falls short"
    )
    assert perfect.strip().startswith("In the drives after iteration 4: in no case.")


def test_figures_are_shown_under_their_titles() -> None:
    assert "Driving:\n\n![Driving](figures/driving.png)" in report(experiment(ALONE))


def test_of_the_pictures_of_seeds_the_first_is_shown_and_the_others_linked() -> None:
    text = section(report(experiment(ALONE, seeds=3)), "Pictures")
    assert (
        f"{ERRORS}, seed 0 (also [seed 1](errors/seed_1.png), [seed 2](errors/seed_2.png)):\n\n"
        f"![{ERRORS}, seed 0](errors/seed_0.png)" in text
    )
    assert "![Training tracks](figures/training.png)" in text
    alone = section(report(experiment(ALONE)), "Pictures")
    assert f"{ERRORS}, seed 0:\n" in alone
    partly = report(experiment(ALONE, seeds=2), by_seed={ERRORS: {1: "one.png"}, "Frames": {}})
    assert f"![{ERRORS}, seed 1](one.png)" in section(partly, "Pictures")
    missing = section(partly, "What is missing")
    assert f"- {ERRORS}, seed 0: no picture." in missing
    assert "- Frames, seed 0: no picture.\n- Frames, seed 1: no picture." in missing


def test_nothing_is_missing_of_a_whole_experiment() -> None:
    """The variants are not driven with the optimal safety policy."""
    driven = [run for run in SPECS if not run.startswith("safedagger_")]
    whole = with_optimal(experiment(GOOD, seeds=2), driven)
    first = experiment({"dagger": SLOW[:1]})
    beside = {"thresholds": named(first, "0.01"), "scratch": named(first, SCRATCH)}
    beside["relied_on"] = beside["in_crowd"] = whole
    assert (
        section(report(whole, **beside), "What is missing").strip()
        == "No run, seed or picture is missing."
    )


def test_what_is_missing_is_named() -> None:
    table = {run: levels for run, levels in GOOD.items() if run not in ("supervised", "dagger")}
    found = with_optimal(experiment(table, seeds=2))
    found = without(found, seed=1, run="safedagger", iteration=[2, 3])
    found = without(found, seed=1, run="safedagger_last")
    found = undriven(found, run="dagger_budget", strategy="optimal")
    cut = {"seed": 0, "run": "safedagger_max", "iteration": 1, "strategy": "safe"}
    found = undriven(found, **cut, condition="traffic", scenario="yew")
    found = section(report(found, errors={}), "What is missing").strip().splitlines()
    assert found == [
        "- DAgger: no results, hence no verdict on 6 claims.",
        "- supervised: no results, hence no verdict on 2 claims.",
        "- SafeDAgger, seed 1: no iteration 2, 3.",
        "- SafeDAgger, 1 s ahead (last), seed 1: no results.",
        "- SafeDAgger, 1 s ahead (max), seed 0, iteration 1: 8 of 12 drives of safe, with traffic.",
        "- DAgger, SafeDAgger's queries: no drives with the optimal safety policy.",
        "- Other thresholds: no drives with safety policies of other tau.",
        "- Warm start or from scratch: no primary trained from scratch.",
        "- Seed 0: no errors.json, which says which errors are safe.",
        "- Seed 1: no errors.json, which says which errors are safe.",
        "- Reliability, seed 0: not measured.",
        "- Reliability, seed 1: not measured.",
        "- Reliability in a crowd, seed 0: not measured.",
        "- Reliability in a crowd, seed 1: not measured.",
    ]


def test_a_condition_that_nobody_met_is_missing() -> None:
    made_up = experiment({"dagger": SLOW[:2]})
    text = report(undriven(made_up, condition="traffic", iteration=1))
    assert "- DAgger, seed 0, iteration 1: 0 of 12 drives of naive, with traffic." in text
    assert rows(section(text, "In numbers"), "Laps, naive")["DAgger", "1"][0] == "2.10 / -"


def test_what_conditions_there_are_is_in_the_data() -> None:
    text = report(undriven(experiment({"dagger": SLOW[:1]}), condition="traffic"))
    assert "Traffic: no cars." in text and "completes 2.00 of 3 laps without traffic." in text
    assert "0 of 12 drives" not in text
    assert rows(section(text, "In numbers"), "Laps, naive")["DAgger", "0"][0] == "2.00"


def test_equal_experiments_give_equal_bytes() -> None:
    """In whatever order they were read; here with a drive missing in each step."""
    made_up = experiment({"dagger": scattered(SLOW), "safedagger": scattered(GROWING)}, seeds=2)
    one = {"strategy": "naive", "condition": "no_traffic", "scenario": "spruce", "start": 0}
    made_up = undriven(made_up, **one)
    turned = {
        name: getattr(made_up, name).sort_values("seed", ascending=False, kind="stable")
        for name in ("drives", "ledgers", "quality")
    }
    backwards = replace(made_up, **turned)
    assert report(made_up) == report(made_up) == report(backwards)
    assert report(made_up).count(" drives of naive, without traffic.") == 16


def test_every_run_that_there_is_has_its_line() -> None:
    lines = runs(experiment({run: GOOD[run] for run in ("dagger", "safedagger_max")})).splitlines()
    assert [line.split(" Loop")[0] for line in lines] == [
        f"- {SPECS[run].name}: {SPECS[run].words}" for run in ("dagger", "safedagger_max")
    ]


def test_the_loop_is_that_of_the_ledgers() -> None:
    """Without D_0; the mean over the seeds, and the share of all frames."""

    changes = {
        "frames_driven": lambda of: 1000 * of.iteration,
        "takeover": lambda of: 0.3 * (of.iteration == 3),
        "frames_selected": lambda of: 100 + 10 * of.seed,
    }
    made_up = experiment({"dagger": GOOD["dagger"]}, seeds=2)
    assert runs(reckoned(made_up, changes, run="dagger")).endswith(
        "Loop: 6,000 frames driven, 15.0 % of them by the reference; 315 added."
    )


def test_tau_is_that_of_the_iterations() -> None:
    made_up = experiment({run: GOOD[run] for run in ("safedagger", "safedagger_rising", "dagger")})
    fixed, dagger, _ = runs(made_up).splitlines()
    assert "; tau" not in dagger
    assert fixed.endswith("; tau 0.0025.")
    assert runs(judged(made_up, HELD_OUT, {"tau": lambda of: 0.01 * 2**of.iteration})).endswith(
        "; tau 0.01, 0.02, 0.04, 0.08 after iterations 0, 1, 2, 3."
    )


def test_without_a_loop_there_is_nothing_to_say_of_it() -> None:
    assert "Loop" not in runs(without(experiment(GOOD), iteration=[1, 2, 3]))
