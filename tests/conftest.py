"""Two cores run the suite: one thread a process, and no test fails for being slow."""

import os
import sys

from hypothesis import settings

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # read once, when NumPy and PyTorch are imported
if sys.platform == "linux":
    os.environ.setdefault("MUJOCO_GL", "egl")  # else MuJoCo wants a display
settings.register_profile("suite", deadline=None, max_examples=50)
settings.load_profile("suite")
