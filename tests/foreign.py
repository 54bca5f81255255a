"""A dataset that somebody else has written: as `lerobot-rollout --strategy.type=dagger` would."""

import sys
from pathlib import Path

import numpy as np

from pipeline.data.dataset import Dataset

CAMERAS = ("observation.images.wrist", "observation.images.top")
SHAPES = {CAMERAS[0]: (48, 64, 3), CAMERAS[1]: (64, 96, 3)}
JOINTS = [f"joint_{number}.pos" for number in range(7)]
LENGTHS = (6, 4)
DROVE = [False, True, True, False, False, True, True, False, False, False]


def foreign(
    path: Path,
    *,
    videos: bool,
    cameras: tuple[str, ...] = CAMERAS,
    watched: bool = True,
    seed: int = 0,
) -> Dataset:
    """Cameras, seven joints, their state, a person who takes over if it was `watched`; through
    LeRobot's API."""
    from lerobot.datasets import LeRobotDataset

    picture = {"dtype": "video" if videos else "image", "names": ["height", "width", "channels"]}
    vector = {"dtype": "float32", "shape": (7,), "names": JOINTS}
    features = {
        "action": vector,
        "observation.state": vector,
        **{camera: picture | {"shape": SHAPES[camera]} for camera in cameras},
    }
    if watched:
        features["intervention"] = {"dtype": "bool", "shape": (1,), "names": None}
    dataset = LeRobotDataset.create(
        "local/rollout_arm",
        fps=20,
        features=features,
        root=path,
        robot_type="arm",
        use_videos=videos,
        video_backend="pyav",
    )
    rng = np.random.default_rng(seed)
    row = 0
    for length in LENGTHS:
        for _ in range(length):
            dataset.add_frame(
                {
                    "action": rng.random(7, np.float32),
                    "observation.state": rng.random(7, np.float32),
                    **{c: np.full(SHAPES[c], 20 * row, np.uint8) for c in cameras},
                    **({"intervention": np.array([DROVE[row]])} if watched else {}),
                    "task": "stack the blocks",
                }
            )
            row += 1
        dataset.save_episode()
    dataset.finalize()
    return Dataset.open(path)


def robot(root: Path) -> None:
    """What docs/use-your-own.md calls `theirs`: two of demonstrations, one of a drive that was watched."""
    for seed, name in enumerate(("demos", "more_demos"), 1):
        foreign(root / name, videos=False, cameras=CAMERAS[:1], watched=False, seed=seed)
    foreign(root / "rollout", videos=False, cameras=CAMERAS[:1])


if __name__ == "__main__":
    robot(Path(sys.argv[1]))
