"""All cards at once: the same bytes each time, complete or not at all, and one line for bad input."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cards.conftest import CARDS, OUTPUTS, PLACES
from tests.command import run
from tests.files import tree


def test_cards_have_stable_bytes_and_no_whole_paths(
    finished: Path, house: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Made again elsewhere, where the paths of what they are about are typed as a whole."""
    assert run(f"{CARDS} {PLACES.format(f'{house}/')} {OUTPUTS.format('again')}") == 0
    said = capsys.readouterr().out
    assert said == "4 cards of datasets in again/datasets, 2 of models in again/models\n"
    again = tree(house / "again")
    assert again == tree(finished / "cards")
    assert not [name for name, content in again.items() if str(house).encode() in content]


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


def test_a_missing_folder_is_named(tmp_path: Path, refused: Callable[..., str]) -> None:
    (tmp_path / "cards").mkdir()
    error = refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}")
    assert error == "datasets: there is no such folder\n"


def test_an_empty_folder_is_refused(house: Path, refused: Callable[..., str]) -> None:
    for path in (house / "models").iterdir():
        path.rename(house / path.name)
    (house / "cards").mkdir()
    error = refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}", house)
    assert "no policy in this folder, expected at least one" in error
