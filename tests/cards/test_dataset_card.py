"""Cards of datasets: what LeRobot and the Hub need, and numbers that are the dataset's own."""

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from huggingface_hub import DatasetCard
from lerobot.datasets.utils import create_lerobot_dataset_card
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.diffusion.configuration_diffusion import DiffusionConfig

from pipeline.data.dataset import Dataset
from pipeline.data.ledger import collected
from pipeline.data.merging import merge
from pipeline.data.schema import Asked
from pipeline.data.selecting import select
from pipeline.driving.features import FEATURES
from tests.cards.conftest import ALDER, BIRCH
from tests.episodes import random_episode, write

PAGE = (Path(__file__).parents[2] / "docs/datasets.md").read_text()
NAMES = ["D_0", "D_1", "new_1", "rollout_1"]


@pytest.fixture
def cards(finished: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(finished)
    return finished / "cards" / "datasets"


def read(name: str) -> tuple[Dataset, dict[str, np.ndarray]]:
    dataset = Dataset.open(Path("datasets", name))
    return dataset, dataset.columns(n for n in FEATURES if n not in dataset.cameras)


def number(card: str, row: str) -> int:
    """The first number in a row of one of the card's tables."""
    found = re.search(rf"^\| {re.escape(row)} \| ([\d,]+) \|", card, re.MULTILINE)
    assert found, row
    return int(found[1].replace(",", ""))


def test_every_dataset_has_a_card_and_a_picture(cards: Path) -> None:
    assert sorted(path.name for path in cards.iterdir()) == sorted(
        f"{name}{kind}" for name in NAMES for kind in (".json", ".md", ".jpg")
    )


@pytest.mark.parametrize("name", NAMES)
def test_the_front_matter_is_what_lerobot_writes(name: str, cards: Path) -> None:
    ours = DatasetCard.load(cards / f"{name}.md").data.to_dict()
    theirs = create_lerobot_dataset_card().data.to_dict()
    assert set(theirs.pop("tags")) <= set(ours["tags"])
    assert theirs.items() <= ours.items()
    assert "license" not in ours
    assert ours["size_categories"] == ["n<1K"]


@pytest.mark.parametrize("name", NAMES)
def test_its_numbers_are_the_datasets(name: str, cards: Path) -> None:
    card = (cards / f"{name}.md").read_text()
    dataset, columns = read(name)
    frames = len(dataset)
    assert number(card, "frames") == frames
    assert number(card, "episodes") == len(dataset.lengths)
    assert number(card, "queries") == columns["queried"].sum()
    assert number(card, "frames that the reference drove") == columns["intervention"].sum()
    assert number(card, "frames that brake") == columns["action"][:, 1].sum()
    judged = (columns["safe_probability"] >= 0).sum()
    assert number(card, "frames that a safety policy judged") == judged
    if judged:
        unsafe = (columns["safe_probability"] < 0.5).sum()
        assert number(card, "of these, driven by the reference") == unsafe
        # the labels of this safety policy have the brake in them, the column has not
        squares = (columns["primary_action"] - columns["action"]) ** 2
        above = (squares.sum(axis=1) > 0.05)[columns["queried"][:, 0]].sum()
        row = "of these, unsafe: deviation of steering and brake above tau = 0.05"
        assert number(card, row) == above > (columns["deviation"] > 0.05).sum()
    assert (
        f"| frames that a safety policy judged | {judged} | {100 * judged / frames:.1f} % |" in card
    )


@pytest.mark.parametrize(
    ("row", "affordance", "unit"),
    [
        ("from the middle of the lane, at most [m]", -2, 1.8),
        ("angle to the lane, at most [rad]", -1, 0.5),
    ],
)
def test_it_says_how_far_its_frames_spread(
    row: str, affordance: int, unit: float, cards: Path
) -> None:
    card = (cards / "D_0.md").read_text()
    found = re.findall(rf"^\| {re.escape(row)} \| ([\d.]+) \| (\d+) % \|$", card, re.MULTILINE)
    assert [share for _, share in found] == ["50", "95"]
    amounts = np.abs(read("D_0")[1]["affordances"][:, affordance]) * unit
    for value, share in found:
        assert float(value) == pytest.approx(np.percentile(amounts, int(share)), abs=0.006)


def test_it_counts_each_scenario_and_each_iteration(cards: Path) -> None:
    card = (cards / "D_1.md").read_text()
    _, columns = read("D_1")
    later = int(columns["source.iteration"].sum())  # iterations are 0 and 1
    assert (
        f"| 0 | 2 | 7 | 7 | 7 |\n| 1 | {number(card, '1')} | {later} | {later} | {later} |" in card
    )
    of_each = [number(card, task) for task in (ALDER, BIRCH)]
    assert sum(of_each) == number(card, "episodes")


def test_it_says_what_made_it_and_links_to_that(cards: Path) -> None:
    merged = (cards / "D_1.md").read_text()
    assert "line 8" in merged
    assert "safedagger merge\n" in merged
    assert "Made from [D_0](D_0.md), [new_1](new_1.md)." in merged
    driven = (cards / "rollout_1.md").read_text()
    assert "[primary_0](../models/primary_0.md), [safety_0](../models/safety_0.md)" in driven
    assert "--cut 0.5" in driven
    assert "| drives: road left | 1 |" in driven and "| drives: budget | 1 |" in driven
    assert "drives:" not in merged
    for link in re.findall(r"\]\(([^)]+)\)", merged + driven):
        assert (cards / link).is_file()


def test_it_says_what_its_drives_took_and_what_became_of_them(cards: Path) -> None:
    """Of what was recorded in it: a dataset that was made from others knows no drives."""
    card = (cards / "rollout_1.md").read_text()
    counted = collected(Dataset.open(Path("datasets/rollout_1")))
    names = ("drives", "scenarios", "calls", "switches", "audits")
    assert [number(card, name) for name in names] == [counted[name] for name in names]
    assert number(card, "put back") == number(card, "road left") == 1
    assert (number(card, "touches"), number(card, "failures while collecting")) == (2, 3)
    for name in ("D_0", "D_1", "new_1"):
        assert "| calls |" not in (cards / f"{name}.md").read_text()


def test_its_limits_are_those_of_its_data(cards: Path) -> None:
    limits = {name: (cards / f"{name}.md").read_text().split("## Limits")[1] for name in NAMES}
    _, columns = read("rollout_1")
    unasked = int((~columns["queried"]).sum())
    assert f"In {unasked} of 17 frames nobody asked the reference" in limits["rollout_1"]
    assert f"`deviation` in {unasked} frames" in limits["rollout_1"]
    assert "begin within a drive" not in limits["rollout_1"]
    assert "`action` is the reference's in every frame." in limits["new_1"]
    assert "begin within a drive" in limits["new_1"]
    assert "`primary_action` in 7, `safe_probability` in 7, `deviation` in 7" in limits["D_1"]


def test_it_warns_whoever_trains_policies_that_predict_chunks(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    """Of episodes of 1, 120 and 120 frames, half of the frames have at most 60 left."""
    drives = [random_episode(np.random.default_rng(3), n, task=ALDER) for n in (1, 120, 120)]
    write(house / "datasets" / "long", drives, "rollout")
    folder = make_cards("other") / "datasets"
    cards = {name: (folder / f"{name}.md").read_text() for name in ("long", "new_1")}
    assert number(cards["long"], "frames in an episode, median") == 120
    assert "| episodes of a single frame | 1 | 33.3 % |" in cards["long"]
    assert "half of the frames have at most 60 left in their episode" in cards["long"]
    chunks = ACTConfig().chunk_size, DiffusionConfig().horizon
    told = "LeRobot's ACT takes {} (`--policy.chunk_size`, `--policy.n_action_steps`), its diffusion {}"
    assert told.format(*chunks) in cards["long"]
    assert "--before 1 --after 1" in cards["new_1"] and "--before" not in cards["long"]


def test_of_context_it_says_that_it_is_no_label(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    raw = Dataset.open(house / "datasets" / "rollout_1")
    select(raw, house / "datasets" / "around", after=0.5)
    card = (make_cards("other") / "datasets" / "around.md").read_text()
    assert "What lay up to 0 s before and 0.5 s after is kept around them as context." in card
    assert "the frames that the reference drove." in card
    assert "safedagger select --after 0.5\n" in card
    assert number(card, "queries") == raw.column("queried").sum() < number(card, "frames")
    assert "`queried` is false there, and our trainings pass over them" in card


def test_of_audits_it_says_that_they_are_some(house: Path, make_cards: Callable[..., Path]) -> None:
    datasets, audits = house / "datasets", []
    for n in (2, 3):
        drive = random_episode(np.random.default_rng(n), 3, task=ALDER, asked=[Asked.AUDIT] * 3)
        audited = write(datasets / f"rollout_{n}", [drive], "rollout", audit=0.25)
        select(audited, datasets / f"audits_{n}", Asked.AUDIT)
        audits.append(Dataset.open(datasets / f"audits_{n}"))
    merge(audits, datasets / "audits")
    folder = make_cards("other") / "datasets"
    cards = {
        name: (folder / f"{name}.md").read_text() for name in ("rollout_2", "audits_2", "audits")
    }
    assert "A random 0.25 of the others was asked about, too." in cards["rollout_2"]
    assert "frames that the reference was asked about, as audit. Each run" in cards["audits_2"]
    assert "as context" not in cards["audits_2"]
    assert "The audits of several rollouts" in cards["audits"] and "D_i" not in cards["audits"]


def test_the_columns_mean_what_the_page_says(cards: Path) -> None:
    card = (cards / "rollout_1.md").read_text().split("## Columns")[1].split("##")[0]
    meanings = dict(re.findall(r"^\| `([\w.]+)` \| (.+?) \|", card, re.MULTILINE))
    assert set(meanings) == set(FEATURES)
    for name, meaning in meanings.items():
        assert name.startswith("source.") or f"| `{name}` | {meaning} |" in PAGE


def test_the_picture_shows_six_frames(cards: Path) -> None:
    assert cv2.imread(str(cards / "rollout_1.jpg")).shape == (72, 6 * 160 + 5 * 2, 3)


def test_it_is_loaded_as_the_card_says(cards: Path) -> None:
    card = (cards / "D_0.md").read_text()
    names: dict = {}
    exec(card.split("```python\n")[1].split("```")[0], names)
    assert len(names["dataset"]) == 7


def test_of_a_foreign_dataset_the_card_says_that_it_does_not_know(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    (house / "datasets" / "D_0" / "safedagger.json").unlink()
    card = (make_cards("other") / "datasets" / "D_0.md").read_text()
    assert "Not known: there is no `safedagger.json` that says what made it." in card
    assert "Algorithm 1" not in card


def test_a_dataset_without_frames_has_a_card_too(
    house: Path, make_cards: Callable[..., Path]
) -> None:
    """What nobody asked: a rollout in which nothing was unsafe."""
    safe = random_episode(np.random.default_rng(2), 3, task=ALDER, asked=[Asked.NOT] * 3)
    select(write(house / "datasets" / "rollout_2", [safe], "rollout"), house / "datasets" / "new_2")
    folder = make_cards("other") / "datasets"
    card = (folder / "new_2.md").read_text()
    assert "It has no frames: nothing was asked." in card
    assert number(card, "frames") == 0
    assert not (folder / "new_2.jpg").exists()
