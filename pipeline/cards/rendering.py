"""From a card's facts to the card: markdown with the front matter of the Hub. The words are in the
templates.
"""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from huggingface_hub import DatasetCardData, EvalResult, ModelCardData
from jinja2 import Template

from pipeline.driving.metrics import KINDS, METRICS
from pipeline.evaluation.templates import template
from pipeline.evaluation.wording import in_condition
from pipeline.metric import COLLECTED, QUALITY, Metric, shown

type Facts = Mapping[str, Any]

_WIDTH = 96
_COMMANDS = {
    **dict.fromkeys(("D_0", "D_safe", "D_held", "supervised"), "collect"),
    "primary": "train-primary",
    "safety": "train-safety",
}
"""By purpose, where the command has another name."""
_SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (10**6, "100K<n<1M"))


def dataset_card(facts: Facts) -> str:
    """The card of a dataset, from what `facts.dataset_facts` says."""
    frames = facts["total"]["frames"]
    data = DatasetCardData(  # there is no license to name
        pretty_name=facts["name"],
        tags=["LeRobot", "safedagger"],
        task_categories=["robotics"],
        size_categories=[next((name for most, name in _SIZES if frames < most), "1M<n<10M")],
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )
    of_drives = shown({**COLLECTED, **KINDS}, "cards").values()
    return _template("dataset").render(facts, front_matter=data.to_yaml(), of_drives=of_drives)


def model_card(facts: Facts) -> str:
    """The card of a policy, from what `facts.policy_facts` says."""
    driven, detected = shown(METRICS, "cards"), shown(QUALITY, "cards")
    tracks = ", ".join(facts["tracks"])
    results = []
    for each in facts["driving"]:
        where = f"{each['strategy']} strategy, {in_condition(each['condition'])}"
        results += _results("safedagger/Driving-v0", tracks, where, each, driven)
    if facts["held_out"]:
        results += _results("local/D_safe", "D_safe", "held out", facts["held_out"], detected)
    names = [each["name"] for each in facts["datasets"] if each["card"]]
    data = ModelCardData(
        model_name=facts["name"],
        library_name="lerobot",
        pipeline_tag="robotics",
        tags=["robotics", "lerobot", facts["kind"]],
        datasets=[f"local/{name}" for name in names] or None,
        eval_results=results or None,
    )
    return _template("model").render(
        facts, front_matter=data.to_yaml(), of_drives=driven, of_detection=detected
    )


def typed(made: Facts) -> str:
    """The command that made something, without its paths, in lines that a shell takes as one."""
    lines = [f"safedagger {_COMMANDS.get(made['purpose'], made['purpose'])}"]
    for name, value in made["arguments"].items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, bool):
            option = option if value else f"--no-{option[2:]}"
        elif isinstance(value, dict):
            continue
        else:
            option = f"{option} {shlex.quote(str(value))}"  # stays with its value
        if len(lines[-1]) + len(option) > _WIDTH:
            lines.append("   ")
        lines[-1] += f" {option}"
    return " \\\n".join(lines)


def _template(name: str) -> Template:
    path = Path(__file__).with_name(f"{name}.md.j2")
    return template(path, typed=typed, setting=_setting)


def _setting(value: Any) -> str:
    """Of a policy's configuration."""
    if isinstance(value, dict):
        return ", ".join(f"{part} {weight:g}" for part, weight in value.items())
    return str(value)


def _results(
    dataset: str, name: str, config: str, measured: Facts, metrics: Mapping[str, Metric]
) -> list[EvalResult]:
    """Of each metric that has a value, for `model-index`: the Hub knows no null."""
    return [
        EvalResult(
            task_type="robotics",
            dataset_type=dataset,
            dataset_name=f"{name}, {config}",
            dataset_config=config,
            metric_type=key,
            metric_name=f"{metric.title} [{metric.unit}]",
            metric_value=measured[key],
        )
        for key, metric in metrics.items()
        if measured[key] is not None
    ]
