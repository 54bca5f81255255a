"""How to load a policy and drive it: code that runs as it stands, where the project is."""

from pipeline.cards.policy import PolicyFacts
from pipeline.driving.tracks import TEST
from pipeline.rollout.strategies import Strategy

_TRAFFIC, _SECONDS = 12, 10  # of the drive that the code takes


def quickstart(
    policy: PolicyFacts, primary: str | None, safety: str | None, action_repeat: int
) -> str:
    """Markdown: the code, and what it does.

    Args:
        policy: the one to show.
        primary: path of the primary that drives; None where it is not known.
        safety: path of its safety policy; None lets the primary drive alone.
        action_repeat: control steps for which an action is held.
    """
    if primary is None:
        return "The primary that it watches is not known, so there is nothing to drive."
    paths = ", ".join(f'Path("{path}")' for path in (primary, safety) if path)
    rule = f"safe.Safe({policy.config['cut']})" if safety else "naive.Naive()"
    strategy = Strategy.SAFE if safety else Strategy.NAIVE
    track = next(iter(TEST))
    kind, name = (
        ("policies.safety", "SafetyPolicy") if safety else ("driving.policy", "PrimaryPolicy")
    )
    return f"""```python
from pathlib import Path
from pipeline.driving.task import Driving
from pipeline.policies.inference import Driver
from pipeline.rollout import plans
from pipeline.rollout.rules import naive, safe

driver = Driver.load({paths})
task = Driving(tracks="{track}", traffic={_TRAFFIC}, action_repeat={action_repeat}, \
seconds={_SECONDS})
plan = plans.Plan(task, "{track}", {rule}, (0,))
for _, frame in plans.driven(plan, driver):
    print(f"{{frame.outcome['laps']:.3f}} laps", "reference" if frame.intervention else "primary")
```

In a checkout of the project, with its environment active. It drives by the {strategy} strategy, on the test track
{track} with {_TRAFFIC} other cars, for at most {_SECONDS} s.
To LeRobot it is `pipeline.{kind}.{name}`, whose `from_pretrained` loads it too."""
