"""What an iteration keeps of its drives: what the reference drove (Algorithm 1, line 7), or, for
DAgger, a uniform sample of all that it was asked about (Sec. 4.2); or what is set aside of D_0. Each
run of neighbours is an episode.
"""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.data.assembling import assemble
from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.pieces import chosen
from pipeline.data.schema import Asked
from pipeline.data.writing import Summary
from pipeline.output import check_place, new_directory


def select(
    dataset: Dataset,
    output: Path,
    because: Asked = Asked.DROVE,
    *,
    before: float = 0,
    after: float = 0,
) -> Summary:
    """Write the rows for which the reference was asked `because`, as the dataset `output`; there may
    be none.

    Where nobody wrote down what was `queried`, it is what the reference drove: `intervention`; and
    where nobody wrote down why, it drove.

    So much [s] of its episode `before` and `after` each of these rows is kept as context. It stays what it was: not
    `queried`, and `action` is the primary's own. What was asked for another reason is none.

    FileExistsError where `output` exists; ValueError where the dataset tells neither, or a time is below
    0 or without end.
    """
    context = {"before": before, "after": after}
    for name, seconds in context.items():
        if not 0 <= seconds < math.inf:
            raise ValueError(f"{name} is {seconds}, expected seconds, 0 or more")
    if not (dataset.has("queried") or dataset.has("intervention")):
        raise ValueError(
            f"{dataset.path}: has neither a column 'queried' nor 'intervention', "
            "expected one that tells which frames the reference was asked about"
        )
    asked = dataset.column("queried")
    rows = asked & (dataset.column("asked_because") == because)
    frames = {name: round(seconds * dataset.fps) for name, seconds in context.items()}
    kept = rows | (_around(dataset, rows, **frames) & ~asked)
    told = {} if because is Asked.DROVE else {"because": because.name.lower()}
    told_of_context = {name: seconds for name, seconds in context.items() if seconds}
    return _keep(dataset, kept, output, Recipe("select", {**told, **told_of_context}))


def _around(
    dataset: Dataset, rows: NDArray[np.bool_], before: int, after: int
) -> NDArray[np.bool_]:
    """[N], the chosen `rows` [N] and so many before and after each, in the same episode."""
    kept, bounds = rows.copy(), dataset.bounds
    for piece in chosen(dataset, rows):
        first, end = bounds[piece.episode]
        kept[max(piece.start - before, first) : min(piece.stop + after, end)] = True
    return kept


def sample(dataset: Dataset, output: Path, frames: int, seed: int) -> Summary:
    """Write a uniform sample of `frames` rows that were queried, without replacement, as the dataset
    `output`; ValueError unless `frames` is from 1 to the queries of the dataset, FileExistsError where
    `output` exists.
    """
    queried = np.flatnonzero(dataset.column("queried"))
    if not 1 <= frames <= len(queried):
        raise ValueError(
            f"frames is {frames}, expected 1 to the {len(queried)} queries of {dataset.path}"
        )
    rows = np.zeros(len(dataset), bool)
    rows[np.random.default_rng(seed).choice(queried, frames, replace=False)] = True
    return _keep(dataset, rows, output, Recipe("sample", {"frames": frames, "seed": seed}))


def split(
    dataset: Dataset, output: Path, aside: Path, share: float, seed: int
) -> tuple[Summary, Summary]:
    """Write a random `share` of the episodes as the dataset `aside`, the others as `output`; ValueError
    where one side would be left without any, or both are one path, FileExistsError where one of the two
    exists.
    """
    episodes = len(dataset.lengths)
    count = round(share * episodes)
    if not 0 < count < episodes:
        raise ValueError(
            f"share is {share} of the {episodes} episodes of {dataset.path}, "
            "expected some on both sides"
        )
    check_place(output, aside)
    drawn = np.random.default_rng(seed).choice(episodes, count, replace=False)
    rows = np.isin(dataset.episode_index, drawn)
    told = {"share": share, "seed": seed}
    with new_directory(output) as others, new_directory(aside) as apart:
        _assemble(dataset, ~rows, others, Recipe("split", told | {"part": "the others"}))
        _assemble(dataset, rows, apart, Recipe("split", told | {"part": "set aside"}))
    return Summary.of(Dataset.open(output)), Summary.of(Dataset.open(aside))


def _keep(dataset: Dataset, rows: np.ndarray, output: Path, recipe: Recipe) -> Summary:
    with new_directory(output) as root:
        _assemble(dataset, rows, root, recipe)
    return Summary.of(Dataset.open(output))


def _assemble(dataset: Dataset, rows: np.ndarray, root: Path, recipe: Recipe) -> None:
    made = Recipe(recipe.purpose, recipe.arguments, [dataset.lineage])
    assemble(root, chosen(dataset, rows), made, like=dataset, features=dataset.with_core)
