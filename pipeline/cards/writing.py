"""All cards of a catalogue, into two folders: beside each, as JSON, the facts that it says."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pipeline.cards.catalogue import Catalogue, place
from pipeline.cards.facts import dataset_facts
from pipeline.cards.policy import policy_facts
from pipeline.cards.rendering import dataset_card, model_card
from pipeline.cards.strip import sample_rows, strip
from pipeline.data.images import read_some_images
from pipeline.data.lineage import Lineage
from pipeline.driving.features import CAMERA
from pipeline.evaluation.writing import write_metrics


def write_dataset_cards(folder: Path, catalogue: Catalogue) -> dict[str, dict[str, Any]]:
    """Write <name>.json, <name>.md and <name>.jpg for each dataset into `folder`, which is made.

    Returns:
        The facts of each dataset, by its sha256.

    Raises:
        ValueError: a dataset is another robot's, or a picture is damaged.
    """
    folder.mkdir()
    found = {}
    for dataset in catalogue.datasets:
        lineage, name = dataset.lineage, dataset.path.name
        facts = found[lineage.sha256] = {
            **dataset_facts(dataset),
            "place": place(dataset.path),
            "picture": f"{name}.jpg" if len(dataset) else None,
            "made": asdict(lineage.own),
            "parents": [catalogue.link(parent, lineage) for parent in lineage.parents],
        }
        if facts["picture"]:
            images = read_some_images(dataset, CAMERA, sample_rows(len(dataset)))
            (folder / facts["picture"]).write_bytes(strip(images))
        write_metrics(folder / f"{name}.json", facts)
        write_card(folder / f"{name}.json")
    return found


def write_model_cards(
    folder: Path,
    catalogue: Catalogue,
    datasets: Mapping[str, Mapping[str, Any]],
    *,
    metrics: Path,
    action_repeat: int,
) -> int:
    """Write <name>.json and <name>.md for each policy into `folder`, which is made.

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
        facts = policy_facts(path, metrics)
        watched = facts["config"]["primary_sha256"] if facts["is_safety"] else lineage.sha256
        primary = catalogue.model(watched)
        facts |= {
            "place": place(path),
            "primary": place(primary) if primary else None,
            "action_repeat": action_repeat,
            "made": asdict(lineage.own),
            **_trained_on(lineage, catalogue, datasets),
        }
        write_metrics(folder / f"{path.name}.json", facts)
        write_card(folder / f"{path.name}.json")
    return len(catalogue.models)


def write_card(facts: Path) -> None:
    """Write the card beside its facts."""
    found = json.loads(facts.read_text())
    text = model_card(found) if "layers" in found else dataset_card(found)
    facts.with_suffix(".md").write_text(text, encoding="utf-8")


def _trained_on(
    lineage: Lineage, catalogue: Catalogue, datasets: Mapping[str, Mapping[str, Any]]
) -> dict[str, Any]:
    """Datasets, with their sizes where they are still there, and policies."""
    policies, data = [], []
    scenarios = set()
    for parent in lineage.parents:
        link = catalogue.link(parent, lineage)
        if parent.own.purpose in ("primary", "safety"):
            policies.append(link)
        else:
            facts = datasets.get(parent.sha256)
            total = facts["total"] if facts else {"episodes": None, "frames": None}
            data.append(link | {name: total[name] for name in ("episodes", "frames")})
            scenarios |= {each["name"] for each in facts["scenarios"]} if facts else set()
    return {"datasets": data, "policies": policies, "scenarios": len(scenarios)}
