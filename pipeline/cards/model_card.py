"""The card of a policy: what it is, what it learned from, how it drives, and how to drive it."""

from collections.abc import Sequence
from dataclasses import dataclass

from huggingface_hub import ModelCard

from pipeline.cards.facts import Facts
from pipeline.cards.measured import Measured
from pipeline.cards.model_index import front_matter
from pipeline.cards.origin import shown
from pipeline.cards.policy import PolicyFacts
from pipeline.cards.purposes import PROJECT
from pipeline.cards.quickstart import quickstart
from pipeline.cards.results import detection, driving
from pipeline.data.lineage import Made
from pipeline.driving.features import AFFORDANCES
from pipeline.evaluation.summary import CONDITIONS
from pipeline.evaluation.wording import CONDITION_WORDS, count, share, table
from pipeline.rollout.strategies import Strategy

_CONFIG = {
    "primary_sha256": "of the weights of the primary that it watches: it fits no other",
    "features_of": "of a primary of LeRobot's, the module whose input it reads",
    "features": "numbers that it reads of what its primary looked at",
    "channels": "channels of Conv1 to Conv4; Conv5 has twice as many",
    "sensor_range": "distance that its affordances know as 1 [m]",
    "brake_cut": "it brakes where the brake's probability is above this",
    "loss": "what each part of its loss counts for",
    "hidden": "width of each of the two hidden layers",
    "tau": "threshold of its labels: safe is a deviation of at most this",
    "measure": "what deviates, squared",
    "horizon": "how far ahead its labels look [s]",
    "horizon_mode": "of the deviations within that, which one counts",
    "cut": "unsafe is a safe probability below this",
    "balance": "class weights in its training: 0 none, 1 balanced",
}
"""What the fields of config.json that are ours mean."""


@dataclass(frozen=True)
class Training:
    """What a policy was made from. Links are markdown, as seen from the card."""

    made: Made
    datasets: Sequence[tuple[str, Facts | None]]
    """each dataset's link, and its facts where it is still there"""
    policies: Sequence[str]
    """links: the primary that it starts from, or that it watches"""


def render_model_card(
    policy: PolicyFacts,
    measured: Measured,
    *,
    training: Training | None,
    primary: str | None,
    safety: str | None,
    action_repeat: int,
) -> str:
    """The card as markdown with the front matter of a model on the Hub.

    Args:
        policy: what it is.
        measured: what it is worth.
        training: what it was made from; None where that is not known.
        primary: path of the primary to drive: the policy itself, or the one it watches; None where
            that is not known.
        safety: path of the policy if it is a safety policy, else None.
        action_repeat: control steps for which an action is held in its datasets.
    """
    datasets = [facts for _, facts in training.datasets if facts] if training else []
    return str(
        ModelCard(
            f"""---
{front_matter(policy, measured, [facts.name for facts in datasets]).to_yaml()}
---

# {policy.name}

{_what(policy)} {PROJECT}

{_network(policy)}

{_config(policy)}

## What it was trained on

{_training(policy, training)}

## How it drives

{driving(measured)}{detection(measured)}

## Limits

{_limits(policy, measured, datasets)}

## Load it and drive

{quickstart(policy, primary, safety, action_repeat)}
"""
        )
    )


def _what(policy: PolicyFacts) -> str:
    if policy.is_safety:
        return (
            "A safety policy (pi_safe of Algorithm 1): from the Conv5 activations of one primary "
            "policy it tells whether that one may be trusted here, without asking the reference."
        )
    return (
        "A primary policy (pi_i of Algorithm 1): from one image of the front camera to steering and "
        "brake. It learned by imitating the reference policy, which sees the true state; the "
        f"{len(AFFORDANCES)} affordances are targets of its training, and no input."
    )


def _network(policy: PolicyFacts) -> str:
    rows = [
        [f"`{part.name}`", " x ".join(map(str, part.shape)), count(part.parameters)]
        for part in policy.parts
    ]
    return table(
        ["layer", "weights", "parameters"], [*rows, ["all", "", count(policy.parameters)]], words=2
    )


def _config(policy: PolicyFacts) -> str:
    rows = []
    for name, meaning in _CONFIG.items():
        value = policy.config.get(name)
        if isinstance(value, dict):
            value = ", ".join(f"{part} {weight:g}" for part, weight in value.items())
        if value not in (None, ""):
            rows.append([f"`{name}`", meaning, f"{value}"])
    return table(["`config.json`", "meaning", "value"], rows, words=3)


def _training(policy: PolicyFacts, training: Training | None) -> str:
    if training is None:
        return "Not known: there is no `safedagger.json` that says what made it."
    rows = [
        [link, *((count(f.total.episodes), count(f.total.frames)) if f else ("-", "-"))]
        for link, f in training.datasets
    ]
    parts = [table(["dataset", "episodes", "frames"], rows)] if rows else []
    if training.policies:
        what = "The primary that it watches" if policy.is_safety else "It starts from"
        parts.append(f"{what}: {', '.join(training.policies)}.")
    return "\n\n".join([*parts, shown(training.made)])


def _limits(policy: PolicyFacts, measured: Measured, datasets: Sequence[Facts]) -> str:
    found = ["It sees one image and remembers none: what one image does not show, it cannot know."]
    scenarios = {task for facts in datasets for task in facts.scenarios}
    if scenarios:
        found.append(
            f"All that it was trained on is simulated, in {len(scenarios)} scenarios (a track and "
            "its traffic). Nothing says how it does on a real road."
        )
    strategy = Strategy.SAFE if policy.is_safety else Strategy.NAIVE
    for condition in CONDITIONS:
        of = measured.driving.get((strategy, condition))
        if of:
            found.append(
                f"By the {strategy} strategy {CONDITION_WORDS[condition]} it was driven {of['drives']} "
                f"times, with one seed: {share(of['off_road'])} of these drives left the road."
            )
    if policy.is_safety:
        found.append("It needs the reference policy at hand: somebody has to take over.")
        found.append("It fits its own primary only: another one's Conv5 means something else.")
        if measured.held_out and measured.held_out.recall is not None:
            missed = share(1 - measured.held_out.recall)
            found.append(f"Of the unsafe frames that it was measured on, it missed {missed}.")
    else:
        found.append("It steers and brakes; the speed is a governor's.")
    return "\n".join(f"- {limit}" for limit in found)
