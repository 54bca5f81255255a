"""The policies: reference, primary and safety, and the strategies that choose who drives.

`network` and `inference` are plain PyTorch and quick to import, for the processes that drive.
`primary` and `safety` wrap the same networks as LeRobot policies, which takes about 15 s to import.
"""

import os

# Hugging Face reads this once, when it is first imported; our policies live on this disk only.
os.environ.setdefault("HF_HUB_OFFLINE", "1")
# PyTorch's threads read this once: they sleep where they wait for one another. Where something else
# runs on the machine, those that spin instead take the processor from those they wait for.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
