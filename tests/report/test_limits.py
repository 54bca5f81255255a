"""What SafeDAgger is short of, in numbers of the experiment."""

from pipeline.evaluation.experiment import ROLLOUT, Experiment
from pipeline.report.limits import limits
from tests.evaluation.made_up import GROWING, SLOW, experiment, judged, with_optimal


def limits_of(made_up: Experiment) -> str:
    return limits(made_up, "safedagger")


def in_rollouts(made_up: Experiment) -> Experiment:
    """Iterations 0, 1 and 2 decided in a rollout; seed 1 better than seed 0."""
    return judged(
        made_up,
        ROLLOUT,
        {
            "recall": lambda of: of.iteration.map({0: 0.5, 1: 0.3, 2: 0.4}) + 0.1 * of.seed,
            "auroc": lambda of: of.iteration.map({0: 0.7, 1: 0.6, 2: 0.8}) + 0.1 * of.seed,
        },
    )


def made_up() -> Experiment:
    return experiment({"safedagger": GROWING, "dagger": SLOW}, seeds=2)


def test_each_limit_has_its_numbers() -> None:
    optimal = with_optimal(in_rollouts(made_up()), takeover_frames=150, primary_frames=850)
    found, takeover, steering = limits_of(optimal).splitlines()
    assert "called unsafe 35.0 % to 55.0 % of the truly unsafe frames" in found
    assert "an AUROC of 0.65 to 0.85 (" in found
    assert takeover.startswith("- After iteration 3, the reference drives 2.0 % and 5.0 % of the")
    assert "and 15.0 % and 15.0 % under the optimal one" in takeover
    assert "driven naively, is 0.005 and 0.006" in steering
    assert steering.endswith("and 0.015 and 0.024 in DAgger.")


def test_what_was_not_measured_has_no_point() -> None:
    (only,) = limits_of(made_up()).splitlines()
    assert "steering MSE" in only
    assert limits_of(experiment({"safedagger": GROWING})) == ""


def test_a_single_rollout_has_no_range() -> None:
    once = experiment({"safedagger": GROWING[:1]})
    assert "unsafe 50.0 % of the truly" in limits_of(in_rollouts(once))
