"""All cards of a catalogue, into two folders: beside each, as JSON, the facts that it says."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cards.catalogue import Catalogue, place
from pipeline.cards.facts import dataset_facts
from pipeline.cards.policy import policy_facts
from pipeline.cards.rendering import dataset_card, model_card
from pipeline.data.images import read_some_images
from pipeline.data.lineage import Lineage
from pipeline.driving.features import CAMERA, IMAGE_SHAPE
from pipeline.evaluation.writing import write_metrics

STRIP_FRAMES = 6  # frames in the strip beside a card, small enough to lie in git
STRIP_GAP = 2  # [pixels] of white between frames
JPEG_QUALITY = 80  # of the JPEG: about 4 kB a frame


def write_dataset_cards(folder: Path, catalogue: Catalogue) -> dict[str, dict[str, Any]]:
    """Write <name>.json, <name>.md and <name>.jpg for each dataset into `folder`, which is made; the facts
    of each, by its sha256. ValueError where one is another robot's, or a picture is damaged.
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
    """Write <name>.json and <name>.md for each policy into `folder`, which is made; how many there are.

    `datasets` are their facts by sha256, `metrics` is the folder of what was measured, and an action was
    held for `action_repeat` control steps. FileNotFoundError where there is no such folder; ValueError
    where a policy or a metric is not what it should be.
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


def sample_rows(frames: int, count: int = STRIP_FRAMES) -> list[int]:
    """The rows in the middle of `count` equal parts of `frames` rows; all where there are fewer."""
    count = min(count, frames)
    return [(2 * part + 1) * frames // (2 * count) for part in range(count)]


def strip(images: Sequence[NDArray[np.uint8]]) -> bytes:
    """Images [72, 160, 3] beside each other, as a JPEG; the same images give the same bytes."""
    gap = np.full((IMAGE_SHAPE[0], STRIP_GAP, 3), 255, np.uint8)
    parts = [part for image in images for part in (gap, image)][1:]
    picture = cv2.cvtColor(np.concatenate(parts, axis=1), cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


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
