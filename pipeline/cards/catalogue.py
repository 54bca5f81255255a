"""What there are cards of, and how one card finds another."""

import os
from pathlib import Path

from pipeline.cards.lineage import Origin, read_origins, whole


class Catalogue:
    """The datasets and policies in two folders, where each comes from, and where its card will be.

    Args:
        datasets: a folder of datasets.
        models: a folder of policies; it may be the same one.
        lock: a dvc.lock; None where nothing is known of where they come from.
        dataset_cards: the folder of the datasets' cards.
        model_cards: the folder of the policies' cards.

    Raises:
        FileNotFoundError: a folder or the lock is missing.
        ValueError: there is nothing in a folder, or the lock is none.
    """

    def __init__(
        self,
        datasets: Path,
        models: Path,
        lock: Path | None,
        *,
        dataset_cards: Path,
        model_cards: Path,
    ) -> None:
        self.datasets = _with(datasets, "meta", "dataset")
        self.models = _with(models, "config.json", "policy")
        self._origins = read_origins(lock) if lock else {}
        self._folders = {True: dataset_cards, False: model_cards}
        self._cards = {whole(path): dataset_cards / f"{path.name}.md" for path in self.datasets} | {
            whole(path): model_cards / f"{path.name}.md" for path in self.models
        }

    def origin(self, path: Path) -> Origin | None:
        """The stage that made a dataset or a policy, where that is known."""
        return self._origins.get(whole(path))

    def parents(self, path: Path) -> list[Path]:
        """What that stage read of what other stages had made."""
        origin = self.origin(path)
        return list(origin.parents) if origin else []

    def link(self, made: Path, card_of: Path) -> str:
        """In markdown, from the card of `card_of` to the card of `made`; its name if it has none."""
        card = self._cards.get(whole(made))
        if card is None:
            return f"`{made.name}`"
        return f"[{made.name}]({_seen_from(self._cards[whole(card_of)].parent, card)})"


def place(path: Path) -> str:
    """Where a dataset or policy is, as seen from here: a card never shows a whole path."""
    return _seen_from(Path(), path)


def _seen_from(folder: Path, path: Path) -> str:
    return Path(os.path.relpath(path, folder)).as_posix()


def _with(folder: Path, part: str, what: str) -> list[Path]:
    """The folders in `folder` that have `part`, sorted by name; not those that are being written."""
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: there is no such folder")
    found = [path.parent for path in folder.glob(f"[!.]*/{part}")]
    if not found:
        raise ValueError(f"{folder}: no {what} in this folder, expected at least one")
    return sorted(found, key=lambda path: path.name)
