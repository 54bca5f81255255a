"""What ACT is shown in the tests, and what it is told to have learned."""

import numpy as np

SHAPES = {"observation.image": (3, 32, 32), "observation.state": (3,), "action": (1,)}
MEAN, STD = 5.0, 2.0  # of the actions


def frame(seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        "observation.image": rng.integers(0, 256, (32, 32, 3), np.uint8),
        "observation.state": rng.random(3, np.float32),
    }
