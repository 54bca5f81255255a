"""The reference in a drive, and how often it was asked: what the query ledger rests on."""

import numpy as np

from pipeline.environment import Action, Environment


class Reference:
    """Asks the reference of an environment, and counts.

    Args:
        env: whose present state is asked about.
        can_look_up: whether it may be asked for nothing, to measure.
    """

    def __init__(self, env: Environment, *, can_look_up: bool) -> None:
        self._env = env
        self._can_look_up = can_look_up
        self.queries = 0
        """how often it was asked for an action to drive or to train with"""
        self.looked_up = 0
        """how often only to measure"""

    def label(self) -> Action:
        """Its action, which is a query."""
        self.queries += 1
        return self._env.label()

    def look_up(self) -> Action:
        """Its action, to measure with; NaN where it cannot be looked up."""
        if not self._can_look_up:
            return np.full(self._env.action_space.shape or (), np.nan, np.float32)
        self.looked_up += 1
        return self._env.look_up()
