"""SafeDAgger as a library: what a world, a policy or a rule of one's own is made of, and what drives.

The commands in stages/ are made of these. Each is imported where it is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.data.dataset import Dataset as Dataset
    from pipeline.data.writing import write_dataset as write_dataset
    from pipeline.environment import Environment as Environment
    from pipeline.metric import Metric as Metric
    from pipeline.policies.inference import Driver as Driver
    from pipeline.policies.lesson import Lesson as Lesson
    from pipeline.rollout.recording import record_all as record_all
    from pipeline.rollout.recording import until_queries as until_queries
    from pipeline.rollout.rules.rule import Decision as Decision
    from pipeline.rollout.rules.rule import Rule as Rule
    from pipeline.rollout.rules.rule import Signals as Signals
    from pipeline.settings import Setting as Setting
    from pipeline.task import Task as Task

_PLACES = {
    "Dataset": "data.dataset",
    "write_dataset": "data.writing",
    "Environment": "environment",
    "Metric": "metric",
    "Driver": "policies.inference",
    "Lesson": "policies.lesson",
    "record_all": "rollout.recording",
    "until_queries": "rollout.recording",
    "Decision": "rollout.rules.rule",
    "Rule": "rollout.rules.rule",
    "Signals": "rollout.rules.rule",
    "Setting": "settings",
    "Task": "task",
}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    """A public name, from where it is."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
