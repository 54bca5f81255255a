"""Whether a dataset has what a policy is to imitate."""

from pathlib import Path

from pipeline.data.reading import read_columns


def check_labels(path: Path) -> None:
    """Check that every row of the dataset `path` has the reference's action.

    Raises:
        ValueError: some rows have the primary's own, as most of a raw rollout; or as
            `check_dataset`.
        FileNotFoundError: as `check_dataset`.
    """
    unlabelled = int((~read_columns(path, ["queried"])["queried"]).sum())
    if unlabelled:
        raise ValueError(
            f"{path}: {unlabelled} frames have no label of the reference, expected none: "
            "`safedagger select` keeps of a rollout those that have one"
        )
