"""Whether a dataset has what a policy is to imitate."""

from pipeline.data.dataset import Dataset


def check_labels(dataset: Dataset) -> None:
    """Check that every row has the reference's action.

    Raises:
        ValueError: some rows have the primary's own, as most of a raw rollout; or there are none.
    """
    if len(dataset) == 0:
        raise ValueError(f"{dataset.path}: no frames, expected some to learn from")
    unlabelled = int((~dataset.column("queried")).sum())
    if unlabelled:
        raise ValueError(
            f"{dataset.path}: {unlabelled} frames have no label of the reference, expected none: "
            "`safedagger select` keeps of a rollout those that have one"
        )
