"""Which frames are one and the same, in whatever datasets they stand."""

from pipeline.data.dataset import Dataset
from pipeline.data.schema import SOURCE

Identity = tuple[int, ...]


def identities(dataset: Dataset) -> list[Identity]:
    """For each row what no other frame has, however it was selected or merged."""
    columns = dataset.columns(SOURCE)
    return list(zip(*(columns[name][:, 0].tolist() for name in SOURCE), strict=True))


def refuse_shared(first: Dataset, second: Dataset) -> None:
    """Raise a ValueError if a frame stands in both datasets."""
    shared = len(set(identities(first)) & set(identities(second)))
    if shared:
        raise ValueError(
            f"{second.path}: {shared} of its frames are in {first.path} too, expected none"
        )
