"""All cards of a catalogue, into two folders."""

from collections.abc import Mapping
from pathlib import Path

from pipeline.cards.catalogue import Catalogue, place
from pipeline.cards.dataset_card import render_dataset_card
from pipeline.cards.facts import Facts, read_facts
from pipeline.cards.measured import read_measured
from pipeline.cards.model_card import Training, render_model_card
from pipeline.cards.policy import PolicyFacts, read_policy
from pipeline.cards.strip import sample_rows, strip
from pipeline.data.images import read_some_images
from pipeline.data.lineage import Lineage
from pipeline.driving.features import CAMERA
from pipeline.policies.loading import weights_sha256


def write_dataset_cards(folder: Path, catalogue: Catalogue) -> dict[str, Facts]:
    """Write <name>.md and <name>.jpg for each dataset into `folder`, which is made.

    Returns:
        The facts of each dataset, by its sha256.

    Raises:
        ValueError: a dataset is another robot's, or a picture is damaged.
    """
    folder.mkdir()
    found = {}
    for dataset in catalogue.datasets:
        lineage = dataset.lineage
        facts = found[lineage.sha256] = read_facts(dataset)
        picture = f"{dataset.path.name}.jpg" if len(dataset) else None
        text = render_dataset_card(
            facts,
            place=place(dataset.path),
            picture=picture,
            made=lineage.own,
            parents=[catalogue.link(parent, lineage) for parent in lineage.parents],
        )
        if picture:
            images = read_some_images(dataset, CAMERA, sample_rows(len(dataset)))
            (folder / picture).write_bytes(strip(images))
        (folder / f"{dataset.path.name}.md").write_text(text, encoding="utf-8")
    return found


def write_model_cards(
    folder: Path,
    catalogue: Catalogue,
    datasets: Mapping[str, Facts],
    *,
    metrics: Path,
    action_repeat: int,
) -> int:
    """Write <name>.md for each policy into `folder`, which is made.

    Args:
        folder: where.
        catalogue: the policies.
        datasets: the facts of the datasets, by sha256.
        metrics: the folder of what was measured.
        action_repeat: control steps for which an action is held.

    Returns:
        How many.

    Raises:
        FileNotFoundError: there is no such folder of metrics.
        ValueError: a policy or a metric is not what it should be.
    """
    if not metrics.is_dir():
        raise FileNotFoundError(f"{metrics}: there is no such folder")
    folder.mkdir()
    for path, lineage in catalogue.models.items():
        policy = read_policy(path)
        primary = _primary(policy, path, catalogue)
        text = render_model_card(
            policy,
            read_measured(metrics, policy.step, _drives(policy, path), safety=policy.is_safety),
            training=_training(lineage, catalogue, datasets),
            primary=place(primary) if primary else None,
            safety=place(path) if policy.is_safety else None,
            action_repeat=action_repeat,
        )
        (folder / f"{path.name}.md").write_text(text, encoding="utf-8")
    return len(catalogue.models)


def _primary(policy: PolicyFacts, path: Path, catalogue: Catalogue) -> Path | None:
    """The policy itself, or the one it watches, if that is here."""
    if not policy.is_safety:
        return path
    return catalogue.model(policy.config["primary_sha256"])


def _drives(policy: PolicyFacts, path: Path) -> str:
    """The SHA-256 of the primary that drives with it."""
    sha256: str = policy.config["primary_sha256"] if policy.is_safety else weights_sha256(path)
    return sha256


def _training(
    lineage: Lineage, catalogue: Catalogue, datasets: Mapping[str, Facts]
) -> Training | None:
    if lineage.own.purpose == "foreign":
        return None
    policies = [parent for parent in lineage.parents if parent.own.purpose in ("primary", "safety")]
    return Training(
        lineage.own,
        [
            (catalogue.link(parent, lineage), datasets.get(parent.sha256))
            for parent in lineage.parents
            if parent not in policies
        ],
        [catalogue.link(parent, lineage) for parent in policies],
    )
