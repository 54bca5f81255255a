"""Our primaries for LeRobot's own commands, which import all that is installed under such a name."""

from pipeline.driving.policy import PrimaryPolicy
from pipeline.policies.conv_policy import ConvPolicy

__all__ = ["ConvPolicy", "PrimaryPolicy"]
