"""What an iteration keeps of its drives: what the reference drove (Algorithm 1, line 7), or, for
DAgger, a uniform sample of all that it was asked about (Sec. 4.2); or what is set aside of D_0. Each
run of neighbours is an episode.
"""

from pathlib import Path

import numpy as np

from pipeline.data.assembling import assemble
from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.pieces import chosen
from pipeline.data.schema import Asked
from pipeline.data.writing import Summary
from pipeline.output import new_directory


def select(dataset: Dataset, output: Path, because: Asked = Asked.DROVE) -> Summary:
    """Write the rows for which the reference was asked `because`, as the dataset `output`; there may
    be none.

    Where nobody wrote down what was `queried`, it is what the reference drove: `intervention`; and
    where nobody wrote down why, it drove.

    Raises:
        FileExistsError: `output` exists.
        ValueError: the dataset tells neither.
    """
    if not (dataset.has("queried") or dataset.has("intervention")):
        raise ValueError(
            f"{dataset.path}: has neither a column 'queried' nor 'intervention', "
            "expected one that tells which frames the reference was asked about"
        )
    told = {} if because is Asked.DROVE else {"because": because.name.lower()}
    rows = dataset.column("queried") & (dataset.column("asked_because") == because)
    return _keep(dataset, rows, output, Recipe("select", told))


def sample(dataset: Dataset, output: Path, frames: int, seed: int) -> Summary:
    """Write a uniform sample of `frames` rows, without replacement, as the dataset `output`.

    Raises:
        FileExistsError: `output` exists.
        ValueError: `frames` is not from 1 to the rows of the dataset.
    """
    if not 1 <= frames <= len(dataset):
        raise ValueError(f"frames is {frames}, expected 1 to the {len(dataset)} of {dataset.path}")
    rows = np.zeros(len(dataset), bool)
    rows[np.random.default_rng(seed).choice(len(dataset), frames, replace=False)] = True
    return _keep(dataset, rows, output, Recipe("sample", {"frames": frames, "seed": seed}))


def split(
    dataset: Dataset, output: Path, aside: Path, share: float, seed: int
) -> tuple[Summary, Summary]:
    """Write a random `share` of the episodes as the dataset `aside`, the others as `output`.

    Raises:
        FileExistsError: one of the two exists.
        ValueError: the share leaves no episodes on either side.
    """
    episodes = len(dataset.lengths)
    count = round(share * episodes)
    if not 0 < count < episodes:
        raise ValueError(
            f"share is {share} of the {episodes} episodes of {dataset.path}, "
            "expected some on both sides"
        )
    drawn = np.random.default_rng(seed).choice(episodes, count, replace=False)
    rows = np.isin(dataset.episode_index, drawn)
    told = {"share": share, "seed": seed}
    return (
        _keep(dataset, ~rows, output, Recipe("split", told | {"part": "the others"})),
        _keep(dataset, rows, aside, Recipe("split", told | {"part": "set aside"})),
    )


def _keep(dataset: Dataset, rows: np.ndarray, output: Path, recipe: Recipe) -> Summary:
    made = Recipe(recipe.purpose, recipe.arguments, [dataset.lineage])
    with new_directory(output) as root:
        assemble(root, chosen(dataset, rows), made, like=dataset, features=dataset.with_core)
    return Summary.of(Dataset.open(output))
