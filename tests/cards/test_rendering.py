"""Cards are what their facts say, and the command that made something is as one types it."""

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from pipeline.cards.rendering import dataset_card, model_card, typed

ROOT = Path(__file__).parents[2]
COMMITTED = sorted((ROOT / "cards").glob("*/*.json"))
LONG = {"purpose": "D_safe", "tracks": "alder, birch", "include_brake": False, "mirror": True}
LONG |= {f"number_{n}": 0.5 for n in range(12)}


@pytest.mark.parametrize("facts", COMMITTED, ids=lambda path: path.stem)
def test_the_committed_card_is_a_fresh_one(facts: Path) -> None:
    """Else: `safedagger cards`, of the datasets and policies that it is about."""
    render = dataset_card if facts.parent.name == "datasets" else model_card
    assert render(json.loads(facts.read_text())) == facts.with_suffix(".md").read_text()


def test_every_committed_card_has_its_facts() -> None:
    cards = {path.with_suffix("") for path in (ROOT / "cards").glob("*/*.md")}
    assert cards == {path.with_suffix("") for path in COMMITTED} and len(cards) == 20


def words(purpose: str, arguments: dict[str, Any]) -> list[str]:
    command = typed({"purpose": purpose, "arguments": arguments})
    assert all(len(line) <= 102 for line in command.splitlines())
    return shlex.split(command.replace("\\\n", ""))


def test_the_command_is_as_one_types_it() -> None:
    found = words("D_safe", LONG)
    assert found[:2] == ["safedagger", "collect"]
    assert found[found.index("--tracks") + 1] == "alder, birch"
    assert "--no-include-brake" in found and "--mirror" in found
    assert found[found.index("--number-11") + 1] == "0.5"


def test_each_purpose_has_its_command() -> None:
    assert words("primary", {"seed": 1}) == ["safedagger", "train-primary", "--seed", "1"]
    assert words("merge", {}) == ["safedagger", "merge"]
    rollout = {"cut": 0.5, "labels": {"tau": 0.1}}
    assert words("rollout", rollout) == ["safedagger", "rollout", "--cut", "0.5"]
