"""Which frames are one and the same, in whatever datasets they stand."""

from pathlib import Path

from pipeline.data.reading import read_columns

_IDENTITY = ("source.iteration", "source.episode", "source.frame", "vehicle_state")
"""Where a frame was first recorded; and where the car then was, since D_0 and D_safe, or two seeds,
number their drives alike.
"""


def identities(path: Path) -> list[tuple[float, ...]]:
    """For each row of the dataset `path` what no other frame has, however it was selected or merged.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`.
    """
    columns = read_columns(path, _IDENTITY)
    parts = (columns[name].T.tolist() for name in _IDENTITY)
    return list(zip(*(numbers for part in parts for numbers in part), strict=True))


def refuse_shared(first: Path, second: Path) -> None:
    """Raise a ValueError if a frame stands in both datasets.

    Raises:
        FileNotFoundError, ValueError: as `check_dataset`, too.
    """
    shared = len(set(identities(first)) & set(identities(second)))
    if shared:
        raise ValueError(f"{second}: {shared} of its frames are in {first} too, expected none")
