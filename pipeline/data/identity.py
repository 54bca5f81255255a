"""Which frames are one and the same, in whatever datasets they stand."""

from itertools import combinations

from pipeline.data.dataset import Dataset
from pipeline.data.schema import SOURCE

Identity = tuple[int, ...]


def identities(dataset: Dataset) -> list[Identity]:
    """For each row what no other frame has, however it was selected or merged."""
    columns = dataset.columns(SOURCE)
    return list(zip(*(columns[name][:, 0].tolist() for name in SOURCE), strict=True))


def refuse_shared(*datasets: Dataset) -> None:
    """Raise a ValueError if a frame stands in two of the datasets."""
    held = [(dataset.path, set(identities(dataset))) for dataset in datasets]
    for (first, frames), (second, others) in combinations(held, 2):
        shared = len(frames & others)
        if shared:
            raise ValueError(f"{second}: {shared} of its frames are in {first} too, expected none")
