"""Datasets made of pieces of others: what is stored passes through as it is, no picture is encoded
or decoded, and equal pieces give equal bytes.

LeRobot has no tool that keeps some frames of an episode, and what it writes depends on more than
the content: on PYTHONHASHSEED, and on absolute paths. So the files are written here, in its format
v3.0, as its loader and its tools read them.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pipeline.data.blocks import Block, write_blocks
from pipeline.data.content import ContentHash
from pipeline.data.dataset import Dataset
from pipeline.data.lineage import Recipe
from pipeline.data.pictures import known_statistics, pass_videos
from pipeline.data.pieces import Piece, stored_rows
from pipeline.data.schema import Feature, pictures


def assemble(
    root: Path,
    pieces: Sequence[Piece],
    recipe: Recipe,
    *,
    like: Dataset,
    features: Mapping[str, Feature],
) -> None:
    """Write `pieces`, in that order, as a dataset of `features`; there may be none.

    One file for each file of the pieces: those of D_{i-1} are taken as they are, so that DVC stores
    them once.

    Args:
        root: a new directory; its parent is there.
        pieces: of datasets with some of `features`; of what one lacks see `stored_rows`.
        recipe: what the new dataset is and comes from.
        like: whose frame rate and robot it has.
        features: its columns.
    """
    content = ContentHash(recipe, features, fps=like.fps, robot=like.info["robot_type"])

    def blocks() -> Iterator[Block]:
        for group, rows in stored_rows(pieces, features):
            lengths, tasks = [len(piece) for piece in group], [piece.task for piece in group]
            content.add(rows, lengths, tasks)
            source = group[0].dataset
            yield Block(rows, lengths, tasks, source.data_files[source.file_of(group[0].start)])

    videos = [name for name in pictures(features) if features[name]["dtype"] == "video"]
    write_blocks(
        root,
        blocks(),
        features,
        like.info,
        seen={camera: known_statistics(pieces, camera) for camera in pictures(features)},
        placed={k: v for camera in videos for k, v in pass_videos(root, pieces, camera).items()},
    )
    for camera in videos:
        places = [piece.dataset.video_of(camera, piece.episode) for piece in pieces]
        files = list(dict.fromkeys(file for file, _ in places))
        content.add_videos([begin for _, begin in places], files)
    content.lineage().write(root)
