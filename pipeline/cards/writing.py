"""All cards of a catalogue, into two folders."""

from collections.abc import Mapping
from pathlib import Path

from pipeline.cards.catalogue import Catalogue, place
from pipeline.cards.dataset_card import render_dataset_card
from pipeline.cards.facts import Facts, read_facts
from pipeline.cards.lineage import whole
from pipeline.cards.measured import driving_file, read_measured
from pipeline.cards.model_card import Training, render_model_card
from pipeline.cards.policy import PolicyFacts, read_policy
from pipeline.cards.strip import sample_rows, strip
from pipeline.data.reading import read_some_images


def write_dataset_cards(folder: Path, catalogue: Catalogue, *, tau: float) -> dict[Path, Facts]:
    """Write <name>.md and <name>.jpg for each dataset into `folder`, which is made.

    Returns:
        The facts of each dataset, by its `whole` path.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    folder.mkdir()
    found = {}
    for path in catalogue.datasets:
        facts = found[whole(path)] = read_facts(path, tau)
        picture = f"{path.name}.jpg"
        images = read_some_images(path, sample_rows(facts.total.frames))
        text = render_dataset_card(
            facts,
            place=place(path),
            picture=picture,
            tau=tau,
            origin=catalogue.origin(path),
            parents=[catalogue.link(parent, path) for parent in catalogue.parents(path)],
        )
        (folder / picture).write_bytes(strip(images))
        (folder / f"{path.name}.md").write_text(text, encoding="utf-8")
    return found


def write_model_cards(
    folder: Path,
    catalogue: Catalogue,
    datasets: Mapping[Path, Facts],
    *,
    metrics: Path,
    record_every: int,
) -> int:
    """Write <name>.md for each policy into `folder`, which is made.

    Args:
        folder: where.
        catalogue: the policies.
        datasets: the facts of the datasets, by `whole` path.
        metrics: the folder of what was measured.
        record_every: control steps for which an action is held.

    Returns:
        How many.

    Raises:
        FileNotFoundError: there is no such folder of metrics.
        ValueError: a policy or a metric is not what it should be.
    """
    if not metrics.is_dir():
        raise FileNotFoundError(f"{metrics}: there is no such folder")
    folder.mkdir()
    for path in catalogue.models:
        policy = read_policy(path)
        primary = _primary(policy, path, catalogue)
        text = render_model_card(
            policy,
            read_measured(metrics, policy.step, safety=policy.is_safety),
            training=_training(path, catalogue, datasets),
            evaluation=catalogue.origin(driving_file(metrics, policy.step)),
            primary=place(primary) if primary else None,
            safety=place(path) if policy.is_safety else None,
            record_every=record_every,
        )
        (folder / f"{path.name}.md").write_text(text, encoding="utf-8")
    return len(catalogue.models)


def _primary(policy: PolicyFacts, path: Path, catalogue: Catalogue) -> Path | None:
    """The policy itself, or the one it watches: as its stage says, else the one of its step."""
    if not policy.is_safety:
        return path
    named = path.with_name(f"primary_{policy.step}")
    read = set(catalogue.parents(path)) or {whole(named)}
    return next((model for model in catalogue.models if whole(model) in read), None)


def _training(path: Path, catalogue: Catalogue, datasets: Mapping[Path, Facts]) -> Training | None:
    origin = catalogue.origin(path)
    if origin is None:
        return None
    policies = [
        parent
        for parent in origin.parents
        if parent.parent == whole(path).parent and parent not in datasets
    ]
    return Training(
        origin,
        [
            (catalogue.link(parent, path), datasets.get(parent))
            for parent in origin.parents
            if parent not in policies
        ],
        [catalogue.link(parent, path) for parent in policies],
    )
