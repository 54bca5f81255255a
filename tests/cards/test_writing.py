"""All cards at once: the same bytes each time, complete or not at all, and one line for bad input."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.command import run
from tests.files import tree

CARDS = "cards --action-repeat 3"
PLACES = "--datasets {0}datasets --models {0}models --metrics {0}metrics"
OUTPUTS = "--dataset-cards {0}/datasets --model-cards {0}/models"


def test_cards_have_stable_bytes_and_no_whole_paths(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    first, again = tree(make_cards("cards")), tree(make_cards("again"))
    assert first == again
    assert not [name for name, content in first.items() if str(house).encode() in content]


def test_whole_paths_as_arguments_are_not_shown(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    expected = tree(make_cards("cards"))
    assert run(f"{CARDS} {PLACES.format(f'{house}/')} {OUTPUTS.format('whole')}") == 0
    assert tree(house / "whole") == expected


def test_the_closing_line_counts_the_cards(
    make_cards: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    make_cards()
    said = capsys.readouterr().out
    assert said == "4 cards of datasets in cards/datasets, 2 of models in cards/models\n"


@pytest.mark.parametrize(
    ("file", "content", "named"),
    [
        ("datasets/D_1/safedagger.json", "[3]", "D_1/safedagger.json: "),
        (
            *("datasets/D_1/meta/info.json", ("brake", "throttle")),
            "datasets/D_1: column 'action' is float32 [2] ['steering', 'throttle'], exp",
        ),
        ("datasets/new_1/meta/info.json", None, "datasets/new_1: not a dataset"),
        ("models/safety_0/model.safetensors", "nonsense", "models/safety_0/model.safetensors: "),
        (
            *("models/primary_0/config.json", '{"type": "act"}'),
            "the policy's type is 'act', expected 'safedagger_primary'",
        ),
        ("metrics/driving_0.json", "[1, 2]", "metrics/driving_0.json: the whole: Input should be "),
        (
            *("metrics/safety_0.json", ('"auroc": 0.75', '"auroc": "high"')),
            "metrics/safety_0.json: rows.0.auroc: Input should be a valid number",
        ),
        ("cards/models", "", "cards/models: exists already"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(
    file: str,
    content: str | tuple[str, str] | None,
    named: str,
    house: Path,
    refused: Callable[..., str],
) -> None:
    """Of a file that is lost, or has another content, be it in one place."""
    path = house / file
    (house / "cards").mkdir()
    if content is None:
        path.unlink()
    else:
        changed = path.read_text().replace(*content) if isinstance(content, tuple) else content
        path.write_text(changed)
    assert named in refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}", house)


def test_an_empty_folder_is_refused(house: Path, make_cards: Callable[..., Path]) -> None:
    for path in (house / "models").iterdir():
        path.rename(house / path.name)
    with pytest.raises(ValueError, match="no policy in this folder, expected at least one"):
        make_cards()
