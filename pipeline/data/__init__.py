"""Datasets: the one schema, writing, reading, selecting, merging, and the query ledger.

A dataset is a LeRobot v3.0 directory. Writing and merging go through LeRobot (about 15 s to
import, so only when called); reading needs pyarrow and OpenCV only.
"""

import os

# Hugging Face reads this once, when it is first imported. Without it LeRobot answers a mistyped
# local path by asking the network.
os.environ.setdefault("HF_HUB_OFFLINE", "1")
