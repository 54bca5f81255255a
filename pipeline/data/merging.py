"""Algorithm 1, line 8: aggregate datasets into one."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from pipeline.data.assembling import assemble
from pipeline.data.dataset import Dataset
from pipeline.data.identity import refuse_shared
from pipeline.data.lineage import Recipe
from pipeline.data.pieces import whole
from pipeline.data.schema import Feature, check_features, may_be_missing
from pipeline.data.writing import Summary
from pipeline.output import new_directory


def merge(datasets: Sequence[Dataset], output: Path) -> Summary:
    """Write the episodes of two or more datasets, in that order, as the dataset `output`.

    Core columns and signals that one lacks are filled, see `filled`; all others must be the same.
    FileExistsError where `output` exists; ValueError where they are fewer, of different robots, frame
    rates or columns, or share a frame.
    """
    if len(datasets) < 2:
        raise ValueError(f"there are {len(datasets)} datasets to merge, expected at least two")
    first = datasets[0]
    for other in datasets[1:]:
        other.require_robot_of(first)
    features = _union(datasets)
    refuse_shared(*datasets)
    pieces = [piece for dataset in datasets for piece in whole(dataset)]
    recipe = Recipe("merge", {}, [dataset.lineage for dataset in datasets])
    with new_directory(output) as root:
        assemble(root, pieces, recipe, like=first, features=features)
    return Summary.of(Dataset.open(output))


def filled(datasets: Iterable[Dataset]) -> dict[Path, list[str]]:
    """By the path of a dataset: the columns that it lacks and that others, or the core, have."""
    several = list(datasets)
    features = _union(several)
    lacking = {d.path: [name for name in features if name not in d.features] for d in several}
    return {path: names for path, names in lacking.items() if names}


def _union(datasets: Sequence[Dataset]) -> dict[str, Feature]:
    """All columns of the datasets; those that must not be missing are the same in all of them."""
    union: dict[str, Feature] = {}
    for dataset in datasets:
        union |= {name: of for name, of in dataset.with_core.items() if name not in union}
    for dataset in datasets:
        there = {n: f for n, f in union.items() if n in dataset.features or not may_be_missing(n)}
        try:
            check_features(dataset.features, there)
        except ValueError as error:
            raise ValueError(f"{dataset.path}: {error}, as in the others") from None
    return union
