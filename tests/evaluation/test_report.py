"""The report says what the experiment says, for better or worse, and what it lacks."""

from dataclasses import replace

from pipeline.data.ledger import Ledger
from pipeline.evaluation.experiment import RUNS, Experiment, Step
from pipeline.evaluation.summary import condition
from pipeline.evaluation.verdicts import verdicts
from pipeline.policies.strategies import Strategy
from tests.evaluation.made_up import (
    FRAMES,
    FULL,
    GOOD,
    GROWING,
    SLOW,
    changed,
    ending,
    experiment,
    scattered,
    with_optimal,
)
from tests.evaluation.rendered import ERRORS, report, rows, section

ALONE = {"safedagger": GROWING}


def block(text: str, beginning: str) -> str:
    (found,) = (part for part in text.split("\n\n") if part.startswith(beginning))
    return found


def test_the_first_screen_compares_laps_and_queries() -> None:
    title, standing, headline, picture, cost, basis, *_ = report(experiment(GOOD)).split("\n\n")
    assert title.startswith("# ")
    assert standing == (
        "Of the 13 [claims of the paper](#claims-of-the-paper), 13 hold (1, 2, 3, 4, 5, 6, 7, 8, 9, "
        "10, 11, 12, 13), 0 do not hold, 0 are undecided."
    )
    assert headline.splitlines() == [
        "- After supervised training alone, the primary, driven naively, completes 2.00 of 3 "
        "laps without traffic and 1.50 with traffic.",
        "- After iteration 3 of SafeDAgger, at 7,000 queries, it completes 3.00 and 3.00. All "
        "24 naive drives did 3 laps first after iteration 3, at 7,000 queries. With the safe "
        "strategy it completes 3.00 and 3.00, the reference driving 2.0 % and 5.0 % of the "
        "time; before the loop it was 8.0 % and 20.0 %.",
        "- After iteration 3 of DAgger, at 35,000 queries, it completes 2.40 and 2.10. After no "
        "iteration did all naive drives do 3 laps. SafeDAgger asked 5.0 times fewer queries in "
        "the loop; with D_0, and D_safe that only it needs, 2.4 times fewer labels (15,600 "
        "against 38,000).",
        "- After iteration 3 of DAgger, SafeDAgger's queries, at 9,000 queries, it completes "
        "2.40 and 2.10. After no iteration did all naive drives do 3 laps. SafeDAgger asked 1.3 "
        "times fewer queries in the loop; with D_0, and D_safe that only it needs, 1.3 times as "
        "many labels (15,600 against 12,000).",
        "- After iteration 3 of supervised, at 35,000 queries, it completes 2.40 and 2.10. "
        "After no iteration did all naive drives do 3 laps. SafeDAgger asked 5.0 times fewer "
        "queries in the loop; with D_0, and D_safe that only it needs, 2.4 times fewer labels "
        "(15,600 against 38,000).",
    ]
    assert picture.endswith("(figures/result.png)")
    assert cost.startswith("**Cost.**")
    assert basis.startswith("**Basis.**")


def test_the_first_screen_follows_the_data() -> None:
    dear = [replace(level, queries=14_000) for level in GROWING]
    made_up = experiment(
        {
            "safedagger": ending(dear, laps=(1.0, 0.5)),
            "dagger": SLOW[:2],
            "supervised": ending(dear, laps=(2.0, 0.5)),
        },
        seeds=2,
    )
    partly = {key: step for key, step in made_up.steps.items() if key[:2] != (0, "dagger")}
    headline = report(Experiment(partly)).split("\n\n")[2]
    assert "of SafeDAgger, at 42,000 queries, it completes 1.00 and 0.50" in headline
    assert "After iteration 1 of DAgger on seed 1, at 15,000 queries, it completes" in headline
    assert "SafeDAgger asked 2.8 times as many queries in the loop; with" in headline
    assert "SafeDAgger asked as many queries in the loop; with" in headline
    others = report(experiment({"safedagger_max": GROWING})).split("\n\n")[2]
    assert others == "There are no results of any training strategy."


def test_the_first_line_counts_the_verdicts() -> None:
    mixed = experiment({**GOOD, "safedagger_last": SLOW[:2], "safedagger_rising": SLOW[:3]})
    assert report(mixed).split("\n\n")[1] == (
        "Of the 13 [claims of the paper](#claims-of-the-paper), 11 hold (1, 2, 3, 4, 5, 6, 8, 9, 11, "
        "12, 13), 0 do not hold, 2 are undecided (7, 10)."
    )
    failed = experiment({"safedagger": ending(GROWING, laps=(2.0, 3.0))})
    assert report(failed).split("\n\n")[1] == (
        "Of the 4 [claims of the paper](#claims-of-the-paper), 3 hold (1, 2, 4), 1 does not hold (3), "
        "0 are undecided."
    )


def test_when_all_laps_were_first_done_and_lost_again() -> None:
    """A single drive of one seed is enough to lose them."""
    levels = [FULL, GROWING[0], FULL, FULL]
    made_up = experiment({"safedagger": [GROWING[0], *levels]}, seeds=2)
    step = made_up.steps[1, "safedagger", 4]
    last = [replace(d, laps=2.99) if d == step.drives[0] else d for d in step.drives]
    lost = Experiment({**made_up.steps, (1, "safedagger", 4): replace(step, drives=last)})
    assert (
        "All 48 naive drives did 3 laps first after iteration 1, at 1,000 queries, but no longer "
        "after iteration 2 and 4." in report(lost)
    )


def test_runs_that_share_no_seed_have_no_factor() -> None:
    made_up = experiment({**ALONE, "dagger": SLOW}, seeds=2)
    apart = {key: made_up.steps[key] for key in made_up.steps if key[0] == (key[1] == "dagger")}
    headline = report(Experiment(apart)).split("\n\n")[2]
    assert "of SafeDAgger on seed 0" in headline and "of DAgger on seed 1" in headline
    assert "times" not in headline


def test_what_was_asked_only_to_measure_stands_apart() -> None:
    """By seed 0: 500 frames of a rollout without a query, seed 1: 1,500."""

    def driven(step: Step) -> Step:
        frames = step.ledger.queries + (500 + 1000 * step.seed) * (step.iteration == 1)
        trained = 2000 + 10 * step.iteration
        return replace(
            step, ledger=replace(step.ledger, frames_driven=frames, frames_trained=trained)
        )

    made_up = changed(experiment(ALONE, seeds=2, starts=1), driven)
    d_safe = {seed: Ledger(1, 5000 + 200 * seed, 1, 1, 1.0) for seed in (0, 1)}
    cost = block(report(made_up, d_safe=d_safe), "**Cost.**")
    assert (
        "SafeDAgger asked 7,000 queries a seed, on average, in 8,000 frames driven, after 3,000 "
        "queries for D_0 and 5,100 for D_safe; its last primary was trained on 2,030 frames."
        in cost
    )
    # naive drives, and what the reference did not drive of the safe ones
    naive = 2 * 4 * 6 * FRAMES
    safe = 2 * 3 * sum(round(FRAMES * (2 - sum(level.takeover))) for level in GROWING)
    assert f"asked in 2,000 frames of rollouts and {naive + safe:,} of evaluation" in cost


def test_what_it_rests_on() -> None:
    """Iteration 0 is shared: 22 steps of 36 drives on each seed."""
    basis = block(report(experiment(GOOD, seeds=2, starts=3)), "**Basis.**")
    assert "Seeds 0, 1. Test tracks: spruce, willow, yew. Starts on each: 3." in basis
    assert "Traffic: 40 cars. 1,584 drives in all: naive, in which" in basis
    assert "Each seed again: `make experiment SEED=0`, `make experiment SEED=1`." in basis
    assert "make repro" not in basis
    alone = block(report(experiment(ALONE)), "**Basis.**")
    assert alone.startswith("**Basis.** Seed 0. ")
    assert "Each seed again: `make repro`, with this `seed` in `params.yaml`;" in alone
    assert "`make experiment SEED=0`" in alone


def test_that_all_went_well_is_no_certainty() -> None:
    """Of 18 drives in a cell, 15.3 % can fail without one failing here, once in 20 times."""
    intervals = block(report(experiment(GOOD, seeds=2, starts=3)), "**Intervals.**")
    assert "rests on 18 drives at most" in intervals
    assert "18 drives that all went well still allow that 15 % would fail" in intervals
    assert "one seed" not in intervals
    alone = block(report(experiment(ALONE, starts=1)), "**Intervals.**")
    assert "3 drives that all went well still allow that 63 % would fail" in alone
    assert "With one seed, no interval" in alone


def test_every_verdict_stands_with_its_numbers() -> None:
    made_up = experiment({**GOOD, "supervised": GROWING})
    text = section(report(made_up), "Claims of the paper")
    judged = verdicts(made_up)
    assert {each.verdict for each in judged} > {"holds"}
    for number, each in enumerate(judged, 1):
        words = each.verdict if each.verdict == "holds" else f"**{each.verdict}**"
        assert f"| {number}. {each.claim} | {words} | {each.observed} |" in text
        assert f"\n{number}. {each.evidence}\n" in text


def test_sections_come_in_order_and_without_runs_they_are_left_out() -> None:
    def headings(text: str) -> list[str]:
        return [line.lstrip("# ") for line in text.splitlines() if line.startswith("##")]

    made_up = experiment(GOOD)
    tau = {0.01: experiment({"safedagger": GROWING[:1]})}
    pairs = experiment({"safedagger": GROWING})
    scratch = replace(pairs.steps[0, "safedagger", 3], run="scratch")
    pairs = Experiment({**pairs.steps, (0, "scratch", 3): scratch})
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
    assert "Driving:\n\n![Driving](figures/driving.png)" in report(experiment(GOOD))


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
    whole = changed(
        experiment(GOOD, seeds=2),
        lambda step: step if step.run.startswith("safedagger_") else with_optimal(step),
    )
    beside = {
        "thresholds": {0.01: whole},
        "scratch": Experiment({(0, "scratch", 3): whole.steps[0, "dagger", 3]}),
    }
    assert (
        section(report(whole, **beside), "What is missing").strip()
        == "No run, seed or picture is missing."
    )


def test_what_is_missing_is_named() -> None:
    table = {run: levels for run, levels in GOOD.items() if run not in ("supervised", "dagger")}
    steps = dict(changed(experiment(table, seeds=2), with_optimal).steps)
    del steps[1, "safedagger", 2], steps[1, "safedagger", 3]
    for i in range(4):
        del steps[1, "safedagger_last", i]
        for seed in range(2):
            step = steps[seed, "dagger_budget", i]
            drives = [d for d in step.drives if d.strategy != Strategy.OPTIMAL]
            steps[seed, "dagger_budget", i] = replace(step, drives=drives)
    cut = steps[0, "safedagger_max", 1]
    kept = [d for d in cut.drives if d.strategy != "safe" or d.traffic == 0 or d.track != "yew"]
    steps[0, "safedagger_max", 1] = replace(cut, drives=kept)
    found = section(report(Experiment(steps), errors={}), "What is missing").strip().splitlines()
    assert found == [
        "- supervised: no results, hence no verdict on 1 claim.",
        "- DAgger: no results, hence no verdict on 4 claims.",
        "- SafeDAgger, seed 1: no iteration 2, 3.",
        "- SafeDAgger, 1 s ahead (last), seed 1: no results.",
        "- SafeDAgger, 1 s ahead (max), seed 0, iteration 1: 8 of 12 drives of safe, with traffic.",
        "- DAgger, SafeDAgger's queries: no drives with the optimal safety policy.",
        "- Other thresholds: no drives with safety policies of other tau.",
        "- Warm start or from scratch: no primary trained from scratch.",
        "- Seed 0: no errors.json, which says which errors are safe.",
        "- Seed 1: no errors.json, which says which errors are safe.",
    ]


def test_a_condition_that_nobody_met_is_missing() -> None:
    quiet = changed(
        experiment({"dagger": SLOW[:1]}),
        lambda step: replace(step, drives=[d for d in step.drives if condition(d) == "no_traffic"]),
    )
    text = report(quiet)
    assert "Traffic: no cars." in text
    assert "- DAgger, seed 0, iteration 0: 0 of 12 drives of naive, with traffic." in text
    assert rows(section(text, "In numbers"), "Laps, naive")["DAgger", "0"][0] == "2.00 / -"


def test_equal_experiments_give_equal_bytes() -> None:
    """In whatever order they were read; here with a drive missing in each step."""
    made_up = changed(
        experiment({"dagger": scattered(SLOW), "safedagger": scattered(GROWING)}, seeds=2),
        lambda step: replace(step, drives=step.drives[1:]),
    )
    backwards = Experiment(dict(reversed(made_up.steps.items())))
    assert report(made_up) == report(made_up) == report(backwards)
    assert report(made_up).count(" drives of naive, without traffic.") == 16


def test_every_run_has_its_name() -> None:
    text = report(experiment(GOOD))
    assert all(f"| {name} |" in text for name in RUNS.values())
