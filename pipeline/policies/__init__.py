"""The policies that learn: primary and safety; reading saved ones, and what they propose.

`network` and `inference` are plain PyTorch and quick to import, for the processes that drive.
`conv_policy` and `safety` wrap the same networks as LeRobot policies, which takes about 15 s to import.
"""
