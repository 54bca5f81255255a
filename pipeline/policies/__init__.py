"""The policies: reference, primary and safety, and the strategies that choose who drives.

`network` and `inference` are plain PyTorch and quick to import, for the processes that drive.
`primary` and `safety` wrap the same networks as LeRobot policies, which takes about 15 s to import.
"""
