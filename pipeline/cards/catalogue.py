"""What there are cards of, and how one card finds another."""

from pathlib import Path

from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Lineage
from pipeline.output import seen_from
from pipeline.policies.loading import policy_lineage


class Catalogue:
    """The datasets and policies in two folders, or in one, where each comes from, and in which folder its
    card will be. FileNotFoundError where a folder is missing; ValueError where there is nothing in it,
    or something is not what it should be.
    """

    def __init__(
        self, datasets: Path, models: Path, *, dataset_cards: Path, model_cards: Path
    ) -> None:
        self.datasets = [Dataset.open(path) for path in _with(datasets, "meta", "dataset")]
        self.models = {
            path: policy_lineage(path) for path in _with(models, "config.json", "policy")
        }
        self._cards = {
            dataset.lineage.sha256: dataset_cards / f"{dataset.path.name}.md"
            for dataset in self.datasets
        } | {
            lineage.sha256: model_cards / f"{path.name}.md" for path, lineage in self.models.items()
        }

    def model(self, sha256: str) -> Path | None:
        """The policy whose weights these are, if it is one that is here."""
        return next((path for path, each in self.models.items() if each.sha256 == sha256), None)

    def link(self, made: Lineage, card_of: Lineage) -> dict[str, str | None]:
        """What the card of `card_of` says of `made`: its name, its card and its sha256; its purpose
        and no card if it is not here.
        """
        card = self._cards.get(made.sha256)
        seen = seen_from(self._cards[card_of.sha256].parent, card) if card else None
        name = card.stem if card else made.own.purpose
        return {"name": name, "card": seen, "sha256": made.sha256}


def place(path: Path) -> str:
    """Where a dataset or policy is, as seen from here: a card never shows a whole path."""
    return seen_from(Path(), path)


def _with(folder: Path, part: str, what: str) -> list[Path]:
    """The folders in `folder` that have `part`, sorted by name; not those that are being written."""
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: there is no such folder")
    found = [path.parent for path in folder.glob(f"[!.]*/{part}")]
    if not found:
        raise ValueError(f"{folder}: no {what} in this folder, expected at least one")
    return sorted(found, key=lambda path: path.name)
