"""All cards at once: the same bytes each time, complete or not at all, and one line for bad input; and
their strips of sample frames, evenly spaced, and the dataset's own.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cards.writing import sample_rows, strip
from pipeline.driving.tracks import make_track
from pipeline.inspection.tracks import sample_frame
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
    path.parent.mkdir(exist_ok=True)
    if content is None:
        path.unlink()
    else:
        changed = path.read_text().replace(*content) if isinstance(content, tuple) else content
        path.write_text(changed)
    assert named in refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}", house)


def test_a_missing_folder_is_named(refused: Callable[..., str]) -> None:
    error = refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}")
    assert error == "datasets: there is no such folder\n"


def test_an_empty_folder_is_refused(house: Path, refused: Callable[..., str]) -> None:
    for path in (house / "models").iterdir():
        path.rename(house / path.name)
    error = refused(f"{CARDS} {PLACES.format('')} {OUTPUTS.format('cards')}", house)
    assert "no policy in this folder, expected at least one" in error


@given(st.integers(1, 100_000), st.integers(1, 12))
def test_rows_are_evenly_spaced(frames: int, count: int) -> None:
    rows = sample_rows(frames, count)
    assert len(rows) == min(frames, count)
    assert rows[0] >= 0 and rows[-1] < frames
    steps = np.diff([*rows])
    assert len(rows) == 1 or (steps.min() >= 1 and np.ptp(steps) <= 1)


def test_a_strip_is_small_and_shows_the_images_beside_each_other() -> None:
    images = [sample_frame(make_track(name))[0] for name in ("spruce", "willow", "yew") * 2]
    picture = strip(images)
    assert len(picture) < 30_000
    shown = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert shown.shape == (72, 6 * 160 + 5 * 2, 3)
    for number, image in enumerate(images):
        difference = shown[:, 162 * number :][:, :160].astype(int) - image
        assert np.abs(difference).mean() < 5
