"""Cards of policies: `model-index` from the metrics, and code that runs as printed."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from huggingface_hub import ModelCard

from pipeline.driving.metrics import CONDITIONS, METRICS
from pipeline.evaluation.drives import among, read_drives
from pipeline.evaluation.summary import measure
from pipeline.metric import shown
from tests.evaluation.written import drive_again

NAMES = ["primary_0", "safety_0"]


@pytest.fixture
def cards(finished: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(finished)
    return finished / "cards" / "models"


def test_every_policy_has_a_card(cards: Path) -> None:
    assert sorted(path.stem for path in cards.glob("*.md")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_front_matter_is_a_lerobot_models(name: str, cards: Path) -> None:
    data = ModelCard.load(cards / f"{name}.md").data
    assert (data.library_name, data.pipeline_tag) == ("lerobot", "robotics")
    kind = f"safedagger_{name.removesuffix('_0')}"
    assert {"robotics", "lerobot", kind} == set(data.tags)
    assert data.datasets == ["local/D_0"]
    assert data.model_name == name
    assert "license" not in data.to_dict()


@pytest.mark.parametrize("name", NAMES)
def test_the_model_index_is_what_was_measured(name: str, cards: Path) -> None:
    results = ModelCard.load(cards / f"{name}.md").data.eval_results or []
    found = {(result.dataset_config, result.metric_type): result.metric_value for result in results}
    drives = read_drives(Path("metrics/drives_0.csv"))
    expected = {
        (f"naive strategy, {words}", metric): pytest.approx(value, rel=1e-5)
        for condition, words in CONDITIONS.items()
        for metric, value in measure(
            among(drives, condition=condition), shown(METRICS, "cards")
        ).items()
    }
    if name == "safety_0":
        quality = {"auroc": 0.75, "recall": 0.6, "precision": 0.5}
        quality |= {"share_unsafe": 0.25, "share_predicted_unsafe": 0.3}
        expected |= {("held out", metric): value for metric, value in quality.items()}
    assert found == expected


@pytest.mark.parametrize("whose", ["f" * 64, "unknown"])
def test_what_was_measured_of_another_policy_is_not_shown(
    whose: str, house: Path, make_cards: Callable[..., Path]
) -> None:
    """Of another seed, or of an earlier run."""
    drive_again(house / "metrics" / "drives_0.csv", primary=whose)
    for name in NAMES:
        card = make_cards(f"cards_{whose[:2]}_{name}") / "models" / f"{name}.md"
        assert "Nobody has evaluated it." in card.read_text()
        assert ModelCard.load(card).data.eval_results is None


def test_it_says_what_it_is_and_what_it_learned_from(cards: Path) -> None:
    from pipeline.policies.loading import load_primary

    card = (cards / "primary_0.md").read_text()
    weights = sum(p.numel() for p in load_primary(Path("models/primary_0")).parameters())
    assert f"| all |  | {weights:,} |" in card
    assert "| [D_0](../datasets/D_0.md) | 2 | 7 |" in card
    assert "safedagger train-primary --channels 2\n" in card
    assert "in 2 scenarios" in card
    safety = (cards / "safety_0.md").read_text()
    assert "The primary that it watches: [primary_0](primary_0.md)." in safety
    assert "it missed 40.0 %" in safety
    for link in re.findall(r"\]\(([^)]+)\)", card + safety):
        assert (cards / link).is_file()


@pytest.mark.parametrize("name", NAMES)
def test_its_five_lines_drive(
    name: str, cards: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    threads = torch.get_num_threads()
    code = (cards / f"{name}.md").read_text().split("```python\n")[1].split("```")[0]
    imports, lines = code.split("\n\n")
    assert len(lines.splitlines()) == 5
    exec(f"{imports}\n{lines}", {})
    torch.set_num_threads(threads)
    driven = capsys.readouterr().out.splitlines()
    assert driven and all(re.fullmatch(r"-?\d\.\d{3} laps \w+", line) for line in driven)
    drivers = {line.split()[-1] for line in driven}
    assert drivers == {"primary"} if name == "primary_0" else drivers <= {"primary", "reference"}


def test_without_lineage_and_metrics_the_card_says_that_it_does_not_know(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    for file in (house / "metrics").iterdir():
        file.unlink()
    for name in NAMES:
        (house / "models" / name / "safedagger.json").unlink()
    folder = make_cards() / "models"
    for name in NAMES:
        card = (folder / f"{name}.md").read_text()
        assert "Not known: there is no `safedagger.json` that says what made it." in card
        assert "Nobody has evaluated it." in card
        assert ModelCard.load(folder / f"{name}.md").data.eval_results is None
        assert 'Path("models/primary_0")' in card  # by the hash that its configuration has


def test_without_its_primary_a_safety_policy_shows_no_drive(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    (house / "models" / "primary_0").rename(house / "primary_0")
    card = (make_cards() / "models" / "safety_0.md").read_text()
    assert "there is nothing to drive" in card
