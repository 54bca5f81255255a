"""Settings out of range are refused by name."""

from itertools import product

import pytest

from pipeline.learning.settings import Optimisation, SafetySettings

NAN, INFINITY = float("nan"), float("inf")


def test_the_papers_training_can_be_asked_for():
    settings = Optimisation(
        optimizer="sgd", learning_rate=0.001, batch=64, samples=4_000_000, validation=0.1
    )
    assert settings.patience == 3


@pytest.mark.parametrize(
    ("field", "values"),
    [
        ("optimizer", ["adam"]),
        ("learning_rate", [0, INFINITY]),
        ("weight_decay", [-1, NAN]),
        ("samples", [0]),
        ("batch", [0]),
        ("validation", [-0.1, 1.0]),
        ("patience", [0]),
        ("seed", [-1]),
        ("threads", [0]),
        ("hidden", [0]),
        ("balance", [-0.1, 1.1]),
        ("tau", [-1]),
        ("cut", [NAN]),
        ("horizon", [INFINITY]),
        ("horizon_mode", ["first"]),
        ("held_out", [2]),
        ("calibration", [1.0]),
    ],
)
def test_a_field_out_of_range_is_named(field, values):
    """Of either training that has it."""
    allowed = r"(a number (at least|above) -?\d|'\w+' or '\w+')"
    kinds = [kind for kind in (Optimisation, SafetySettings) if hasattr(kind, field)]
    for kind, value in product(kinds, values):
        with pytest.raises(
            ValueError, match=f"^{field} is {value!r}, expected {allowed}"
        ) as caught:
            kind(**{field: value})
        assert "\n" not in str(caught.value)
    assert SafetySettings in kinds


def test_sgd_needs_frames_to_validate_on():
    with pytest.raises(ValueError, match="validation is 0, expected more"):
        Optimisation(optimizer="sgd", validation=0.0)


def test_a_size_needs_a_threshold_to_be_measured_by():
    with pytest.raises(ValueError, match="tau is 0, expected more: 'size' is"):
        SafetySettings(tau=0, learns="size")
