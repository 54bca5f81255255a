"""All cards at once: the same bytes each time, complete or not at all, and one line for bad input; and
their strips of sample frames, evenly spaced, and the dataset's own.
"""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cards.writing import sample_rows, strip
from pipeline.data.dataset import Dataset
from pipeline.data.images import read_images, read_some_images
from pipeline.driving.features import CAMERA
from pipeline.driving.tracks import make_track
from pipeline.inspection.tracks import sample_frame
from stages import __main__ as cli
from tests.data.conftest import tree

OPTIONS = {
    "--datasets": "datasets",
    "--models": "models",
    "--metrics": "metrics",
    "--action-repeat": "3",
    "--dataset-cards": "cards/datasets",
    "--model-cards": "cards/models",
}


def test_cards_have_stable_bytes_and_no_whole_paths(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    first, again = tree(make_cards("cards")), tree(make_cards("again"))
    assert first == again
    assert not [name for name, content in first.items() if str(house).encode() in content]


def test_whole_paths_as_arguments_are_not_shown(
    house: Path, make_cards: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = tree(make_cards("cards"))
    paths = {"--datasets", "--models", "--metrics"}
    given = {name: str(house / value) for name, value in OPTIONS.items() if name in paths}
    outputs = {"--dataset-cards": "whole/datasets", "--model-cards": "whole/models"}
    arguments = [word for pair in (OPTIONS | given | outputs).items() for word in pair]
    monkeypatch.setattr(sys, "argv", ["safedagger", "cards", *arguments])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 0
    assert tree(house / "whole") == expected


def test_the_closing_line_counts_the_cards(
    make_cards: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    make_cards()
    said = capsys.readouterr().out
    assert said == "4 cards of datasets in cards/datasets, 2 of models in cards/models\n"


def _no_lineage(house: Path) -> None:
    (house / "datasets" / "D_1" / "safedagger.json").write_text("[3]")


def _other_robot(house: Path) -> None:
    info = house / "datasets" / "D_1" / "meta" / "info.json"
    info.write_text(info.read_text().replace("brake", "throttle"))


def _half_written(house: Path) -> None:
    (house / "datasets" / "new_1" / "meta" / "info.json").unlink()


def _no_weights(house: Path) -> None:
    (house / "models" / "safety_0" / "model.safetensors").write_bytes(b"nonsense")


def _no_policy(house: Path) -> None:
    (house / "models" / "primary_0" / "config.json").write_text('{"type": "act"}')


def _no_metrics(house: Path) -> None:
    (house / "metrics" / "driving_0.json").write_text("[1, 2]")


def _half_metrics(house: Path) -> None:
    file = house / "metrics" / "safety_0.json"
    file.write_text(file.read_text().replace('"auroc": 0.75', '"auroc": "high"'))


def _existing(house: Path) -> None:
    (house / "cards" / "models").mkdir(parents=True)


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (_no_lineage, "D_1/safedagger.json: "),
        (
            _other_robot,
            "datasets/D_1: column 'action' is float32 [2] ['steering', 'throttle'], exp",
        ),
        (_half_written, "datasets/new_1: not a dataset"),
        (_no_weights, "models/safety_0/model.safetensors: "),
        (_no_policy, "the policy's type is 'act', expected 'safedagger_primary'"),
        (_no_metrics, "metrics/driving_0.json: the whole: Input should be "),
        (_half_metrics, "metrics/safety_0.json: rows.0.auroc: Input should be a valid number"),
        (_existing, "cards/models: exists already"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(
    spoil: Callable[[Path], None],
    named: str,
    house: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spoil(house)
    before = tree(house)
    arguments = [word for pair in OPTIONS.items() for word in pair]
    monkeypatch.setattr(sys, "argv", ["safedagger", "cards", *arguments])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 2
    error = capsys.readouterr().err
    assert re.fullmatch(r"safedagger: .*\n", error) and named in error
    assert tree(house) == before


def test_an_empty_folder_is_refused(house: Path, make_cards: Callable[..., Path]) -> None:
    for path in (house / "models").iterdir():
        path.rename(house / path.name)
    with pytest.raises(ValueError, match="no policy in this folder, expected at least one"):
        make_cards()


@given(st.integers(1, 100_000), st.integers(1, 12))
def test_rows_are_evenly_spaced(frames: int, count: int) -> None:
    rows = sample_rows(frames, count)
    assert len(rows) == min(frames, count)
    assert rows[0] >= 0 and rows[-1] < frames
    steps = np.diff([*rows])
    assert len(rows) == 1 or (steps.min() >= 1 and np.ptp(steps) <= 1)


@pytest.mark.parametrize("name", ["rollout_1", "D_1", "new_1"])
def test_images_are_those_of_their_rows(name: str, original: Path) -> None:
    dataset = Dataset.open(original / "datasets" / name)
    images = read_images(dataset, CAMERA)
    rows = list(range(0, len(images), 2))
    some = np.stack(read_some_images(dataset, CAMERA, rows))
    np.testing.assert_array_equal(some, images[rows])


def test_a_strip_is_small_and_shows_the_images_beside_each_other() -> None:
    images = [sample_frame(make_track(name))[0] for name in ("spruce", "willow", "yew") * 2]
    picture = strip(images)
    assert len(picture) < 30_000
    shown = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert shown is not None and shown.shape == (72, 6 * 160 + 5 * 2, 3)
    for number, image in enumerate(images):
        difference = shown[:, 162 * number :][:, :160].astype(int) - image
        assert np.abs(difference).mean() < 5
