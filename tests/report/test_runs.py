"""What the runs are, with what their loops did."""

from pipeline.evaluation.experiment import HELD_OUT
from pipeline.report.runs import runs
from tests.evaluation.made_up import GOOD, SPECS, experiment, judged, reckoned, without


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
