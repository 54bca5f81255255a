"""The front matter of a policy's card, with what was measured as the Hub's `model-index`."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from huggingface_hub import EvalResult, ModelCardData

from pipeline.cards.measured import Measured
from pipeline.cards.policy import PolicyFacts
from pipeline.evaluation.wording import CONDITION_WORDS

_DRIVING = {
    "laps": "Laps of a drive",
    "damage_per_lap": "Damage per lap [m^2/s^2]",
    "steering_mse": "Steering MSE",
    "takeover": "Share of frames that the reference drives",
    "off_road": "Share of drives that left the road",
}
_DETECTING = {"auroc": "AUROC", "recall": "Recall of unsafe", "precision": "Precision of unsafe"}


def front_matter(policy: PolicyFacts, measured: Measured, datasets: Sequence[str]) -> ModelCardData:
    """As LeRobot's own card has it, and the results. There is no license to name."""
    return ModelCardData(
        model_name=policy.name,
        library_name="lerobot",
        pipeline_tag="robotics",
        tags=["robotics", "lerobot", policy.kind],
        datasets=[f"local/{name}" for name in datasets] or None,
        eval_results=_results(measured) or None,
    )


def _results(measured: Measured) -> list[EvalResult]:
    found = []
    tracks = ", ".join(measured.tracks)
    for (strategy, condition), performance in measured.driving.items():
        where = f"{strategy} strategy, {CONDITION_WORDS[condition]}"
        found += _of("safedagger/Driving-v0", tracks, where, performance, _DRIVING)
    if measured.held_out:
        found += _of("local/D_safe", "D_safe", "held out", asdict(measured.held_out), _DETECTING)
    return found


def _of(
    dataset: str,
    name: str,
    config: str,
    measured: Mapping[str, float | None],
    metrics: dict[str, str],
) -> list[EvalResult]:
    """Of each metric that has a value: the Hub knows no null."""
    return [
        EvalResult(
            task_type="robotics",
            dataset_type=dataset,
            dataset_name=f"{name}, {config}",
            dataset_config=config,
            metric_type=metric,
            metric_name=words,
            metric_value=measured[metric],
        )
        for metric, words in metrics.items()
        if measured[metric] is not None
    ]
