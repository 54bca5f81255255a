"""What the runs are, with what their loops did."""

from dataclasses import replace

from pipeline.evaluation.experiment import Step
from pipeline.report.runs import runs
from tests.evaluation.made_up import GOOD, SPECS, changed, experiment, of_steps


def test_every_run_that_there_is_has_its_line() -> None:
    lines = runs(experiment({run: GOOD[run] for run in ("dagger", "safedagger_max")})).splitlines()
    assert [line.split(" Loop")[0] for line in lines] == [
        f"- {SPECS[run].name}: {SPECS[run].words}" for run in ("dagger", "safedagger_max")
    ]


def test_the_loop_is_that_of_the_ledgers() -> None:
    """Without D_0; the mean over the seeds, and the share of all frames."""

    def driven(step: Step) -> Step:
        ledger = replace(
            step.ledger,
            frames_driven=1000 * step.iteration,
            takeover=0.3 if step.iteration == 3 else 0.0,
            frames_selected=100 + 10 * step.seed,
        )
        return replace(step, ledger=ledger)

    made_up = changed(experiment({"dagger": GOOD["dagger"]}, seeds=2), driven)
    assert runs(made_up).endswith(
        "Loop: 6,000 frames driven, 15.0 % of them by the reference; 315 added."
    )


def test_tau_is_that_of_the_iterations() -> None:
    def rising(step: Step) -> Step:
        return replace(step, tau=0.01 * 2**step.iteration)

    made_up = experiment({run: GOOD[run] for run in ("safedagger", "safedagger_rising", "dagger")})
    fixed, dagger, _ = runs(made_up).splitlines()
    assert "; tau" not in dagger
    assert fixed.endswith("; tau 0.0025.")
    assert runs(changed(made_up, rising)).endswith(
        "; tau 0.01, 0.02, 0.04, 0.08 after iterations 0, 1, 2, 3."
    )


def test_without_a_loop_there_is_nothing_to_say_of_it() -> None:
    first = {key: step for key, step in experiment(GOOD).steps.items() if step.iteration == 0}
    assert "Loop" not in runs(of_steps(first))
