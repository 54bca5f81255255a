"""What a stage's output is, in the words of Algorithm 1."""

from pipeline.cards.lineage import Origin

PROJECT = (
    "Part of safedagger, which runs SafeDAgger (Zhang & Cho 2016, arXiv:1605.06450) on LeRobot "
    "datasets."
)

_COLLECTED = {
    "D_0": "D_0 of Algorithm 1 (line 1): the reference policy drives. What the first primary "
    "policy imitates.",
    "D_safe": "D_safe of Algorithm 1 (line 2): the reference policy drives, from starts that are "
    "spread wide. The safety policies learn from it, no primary policy ever does.",
    "D_held": "Drives of the reference policy like those of D_0, which nothing is trained on: the "
    "threshold tau is judged by them.",
    "supervised": "What supervised learning adds in iteration {iteration}, in the place of lines "
    "6 and 7 of Algorithm 1: the reference policy drives on.",
}
_MADE = {
    "rollout": "D' of Algorithm 1 (line 6), iteration {iteration}: every frame that was driven. "
    "The primary policy drives where its safety policy says safe, else the reference policy, which "
    "is asked for those frames only.",
    "select": "D' of Algorithm 1 after line 7: of a rollout, the frames that the safety policy "
    "called unsafe. Each run of neighbouring frames is an episode.",
    "rollout-dagger": "What DAgger collects in iteration {iteration}, in the place of line 6 of "
    "Algorithm 1: a mixture of reference and primary policy drives, and the reference is asked "
    "about every frame.",
    "sample": "What DAgger keeps, in the place of line 7 of Algorithm 1: a uniform sample of all "
    "that it drove. Each run of neighbouring frames is an episode.",
    "merge": "D_i of Algorithm 1 (line 8): all that was trained on before, and what an iteration "
    "added.",
}


def purpose(origin: Origin | None) -> str:
    """What the dataset is for; of one with no known origin, only that it is one of ours."""
    words = None
    if origin is not None:
        collected = origin.stage == "collect"
        known, key = (
            (_COLLECTED, origin.option("--purpose")) if collected else (_MADE, origin.stage)
        )
        words = known.get(key or "")
    if origin is None or words is None:
        return "Recorded drives of a simulated car, as this project's stages write them."
    return words.format(iteration=origin.option("--iteration"))
