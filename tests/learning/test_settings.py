"""Settings out of range are refused by name."""

import pytest

from pipeline.learning.settings import Optimisation, SafetySettings

OPTIMISATION = {"optimizer": "adamw", "learning_rate": 1e-3, "weight_decay": 0.01, "samples": 10}


def test_the_papers_training_can_be_asked_for():
    settings = Optimisation(
        optimizer="sgd", learning_rate=0.001, batch=64, samples=4_000_000, validation=0.1
    )
    assert settings.patience == 3


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("optimizer", "adam"),
        ("learning_rate", 0),
        ("learning_rate", float("inf")),
        ("weight_decay", -1),
        ("weight_decay", float("nan")),
        ("samples", 0),
        ("batch", 0),
        ("validation", 1.0),
        ("validation", -0.1),
        ("patience", 0),
        ("seed", -1),
        ("threads", 0),
    ],
)
def test_a_field_out_of_range_is_named(field, value):
    with pytest.raises(ValueError, match=f"^{field} is {value!r}, expected") as caught:
        Optimisation(**OPTIMISATION | {field: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("hidden", 0),
        ("balance", 1.1),
        ("balance", -0.1),
        ("tau", -1),
        ("cut", float("nan")),
        ("horizon", float("inf")),
        ("held_out", 2),
        ("calibration", 1.0),
    ],
)
def test_so_are_those_of_the_safety_policy(field, value):
    fields = OPTIMISATION | {field: value}
    with pytest.raises(ValueError, match=f"^{field} is {value}, expected a number at"):
        SafetySettings(**fields)


def test_a_word_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match=r"^horizon_mode is 'first', expected 'last' or 'max'$"):
        SafetySettings(horizon_mode="first")


def test_sgd_needs_frames_to_validate_on():
    with pytest.raises(ValueError, match="validation is 0, expected more"):
        Optimisation(**OPTIMISATION | {"optimizer": "sgd", "validation": 0.0})


def test_a_size_needs_a_threshold_to_be_measured_by():
    with pytest.raises(ValueError, match="tau is 0, expected more: 'size' is"):
        SafetySettings(tau=0, learns="size")
